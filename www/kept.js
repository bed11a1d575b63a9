// What a tab has open, kept in the browser, so that a reload or a crash in mid-work loses nothing: programs and recordings as
// files, which of them is in sight, how they are read, and what took long to find. Settings are kept apart (settings.js).
//
// sessionStorage outlives a reload and not the tab, so it holds the name of the tab, and IndexedDB the files under it. No other
// tab sees them: a duplicated tab has the session of its original, finds the name locked and goes on with a copy. What a closed tab left behind is deleted when a program is next computed after a day: nothing tells a tab that
// is closed from one that the browser will bring back.

/** @import { Before, Calibration, DiagnosedColumns, Diagnosis, State, Values } from "./types.js" */

const KEY = 'truefeed.tab'
export const STORE = 'tabs'

/** More is not kept, bytes: the browser's room is the user's. */
const MOST = 1_000_000_000

/** @typedef {import("./state/history.js").GivenProgram} KeptProgram */
/** @typedef {{id: number, name: string, bytes: Uint8Array, program: number | null, used: boolean, interval: number | null}} KeptRecording */
/** Its programs by their numbers. @typedef {Omit<Diagnosis, 'runs'> & {runs: {name: string, program: number, columns: DiagnosedColumns}[]}} KeptDiagnosis */
/** What was found, and what it took the place of. @typedef {{calibration: Calibration | null, diagnosis: KeptDiagnosis | null, sample: Before | null}} Found */
/** @typedef {{saved: number, job: string, fixture: number | null, letter: Values, programs: KeptProgram[], recordings: KeptRecording[], selected: number | null, recording: number | null} & Found} Kept */

/** @returns {Promise<IDBDatabase>} */
export function open() {
  return new Promise((resolve, reject) => {
    const asked = indexedDB.open('truefeed', 1)
    asked.onupgradeneeded = () => asked.result.createObjectStore(STORE)
    asked.onsuccess = () => resolve(asked.result)
    asked.onerror = () => reject(asked.error)
  })
}

/** @template T @param {IDBRequest<T>} asked @returns {Promise<T>} */
export const answer = (asked) =>
  new Promise((resolve, reject) => {
    asked.onsuccess = () => resolve(asked.result)
    asked.onerror = () => reject(asked.error)
  })

/** A reload waits this long for the page before it to let go of the name. */
const RELEASE_MS = 1000

/** Whether a name was free: it is this tab's then. @param {string} name @returns {Promise<boolean>} */
const hold = (name) =>
  new Promise((done) => {
    const untilLeft = () => (done(true), new Promise(() => {}))
    navigator.locks.request(`${KEY}.${name}`, { signal: AbortSignal.timeout(RELEASE_MS) }, untilLeft).catch(() => done(false))
  })

/** The name of this tab, and that of what it begins with. @returns {Promise<{own: string, former: string | null}>} */
async function nameTab() {
  const former = sessionStorage.getItem(KEY)
  if (former && (await hold(former))) return { own: former, former }
  const own = crypto.randomUUID()
  sessionStorage.setItem(KEY, own)
  await hold(own)
  return { own, former }
}

/** @type {ReturnType<typeof nameTab> | undefined} */
let named
export const tab = () => (named ??= nameTab())

/** @returns {Kept} */
const nothing = () => ({ saved: 0, job: '', fixture: null, letter: {}, programs: [], recordings: [], selected: null, recording: null, calibration: null, diagnosis: null, sample: null })

/** What this tab had open; nothing where the browser keeps nothing, or takes too long. @returns {Promise<Kept>} */
export async function loadOpen() {
  try {
    const { former } = await tab()
    return former === null ? nothing() : await (await import('./stored.js')).loadTab(former, nothing())
  } catch {
    return nothing()
  }
}

/** What was saved last: files are written again only where something about them changed. */
let last = ''
/** @type {unknown[]} */
let lastFound = []
let saving = Promise.resolve()

/** Keeps what is open, after what is being kept already. @param {State} state */
export function saveOpen(state) {
  const programs = state.programs.map(({ id, name, file, dialect, title, machine, tolerance, setUp, loading }) => {
    const own = machine && { start: machine.start, values: machine.values }
    return { id, name, file, dialect, title, machine: own, tolerance, setUp, loading }
  })
  // What is compared already need not be found again.
  const recordings = state.recordings.map(({ id, name, bytes, chosen, program, match, used, interval }) => ({ id, name, bytes, program: match?.report ? program : chosen, used, interval }))
  const { selected, recording, calibration, sample, job, fixture, letter } = state
  const found = [calibration, state.diagnosis, sample]
  const diagnosis = state.diagnosis && { ...state.diagnosis, runs: state.diagnosis.runs.map((run) => ({ ...run, program: run.program.id })) }
  const standing = JSON.stringify([
    programs.map(({ file, ...own }) => own),
    [job, fixture, letter],
    recordings.map(({ id, program, used, interval }) => [id, program, used, interval]),
    selected,
    recording,
  ])
  if (standing === last && found.every((one, index) => one === lastFound[index])) return
  last = standing
  lastFound = found
  const size = programs.reduce((sum, { file }) => sum + file.size, 0) + recordings.reduce((sum, { bytes }) => sum + bytes.length, 0)
  const files = size <= MOST ? { programs, recordings } : { programs: [], recordings: [] }
  saving = saving.then(() => put({ saved: Date.now(), job, fixture, letter, ...files, selected, recording, calibration, diagnosis, sample }))
}

/** @param {Kept} kept */
async function put(kept) {
  try {
    const { own } = await tab()
    const database = await open()
    await answer(database.transaction(STORE, 'readwrite').objectStore(STORE).put(kept, own))
    database.close()
  } catch {
    // A browser that keeps nothing still computes.
  }
}
