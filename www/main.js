// Starts the page: reads what was kept, mounts the panels, has work done and tells the panels what changed.

import init, { arcCenters, dialects, form as formOfModule, mostCurves, setLengthUnit, setNumbers, termsForm, usualTolerances } from './pkg/truefeed.js'
import { isJob, isStill, programInSight, quotedColumn } from './columns.js'
import { confinedWorker } from './confined.js'
import { fillTexts } from './dom.js'
import { drawn } from './drawing.js'
import { firstModule, wholeModule } from './module.js'
import { Engine } from './engine.js'
import { axis, lengthWord, showLengthsIn } from './format.js'
import { loadOpen, saveOpen } from './kept.js'
import { loadMachines, saveMachines } from './machines.js'
import * as barPanel from './panels/bar.js'
import * as chartPanel from './panels/chart.js'
import * as diagnosticsPanel from './panels/diagnostics.js'
import * as historyPanel from './panels/history.js'
import * as machinePanel from './panels/machine.js'
import * as openedPanel from './panels/opened.js'
import * as programPanel from './panels/program.js'
import * as progressPanel from './panels/progress.js'
import * as recordingPanel from './panels/recording.js'
import * as resultsPanel from './panels/results.js'
import * as settingsPanel from './panels/settings.js'
import * as tolerancesPanel from './panels/tolerances.js'
import { recordingOf } from './recordings.js'
import { loadSettings, saveBefore, saveSettings } from './settings.js'
import { machineActions } from './state/machine.js'
import { programActions } from './state/programs.js'
import { Store } from './state/store.js'
import { say } from './texts.js'
import { whole } from './whole.js'
import { workOn } from './work.js'

/** @import { Document } from "./state/history.js" */
/** @import { Cut, Form, Parameter, Place, Program, Revised, State } from "./types.js" */

const DEBOUNCE_MS = 300

fillTexts(document)

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id))
const failure = element('failure')

/** Says what should never happen, rather than leaving a page that does nothing. @param {string} message */
function fail(message) {
  failure.textContent = say.work.fault(message)
  failure.hidden = false
}
window.addEventListener('error', ({ message }) => fail(say.work.wrong(message)))
window.addEventListener('unhandledrejection', ({ reason }) => fail(say.work.wrong(reason)))

const first = await firstModule()
await init({ module_or_path: first.module })
setNumbers(axis)
setLengthUnit(lengthWord)
const engine = new Engine(first, confinedWorker, wholeModule)

/** @type {Form} */
const form = JSON.parse(formOfModule())
element('version').textContent = form.version
/** @type {Parameter[]} */
const termFields = JSON.parse(termsForm())
const keptOpen = await loadOpen()
const store = new Store(await begun(), form, termFields, heard)
showLengths()
const { state } = store
if (keptOpen.diagnosis) state.diagnosis = (await import('./stored.js')).diagnosisOf(keptOpen, state)
let timer = 0

/** What the page begins with: what this tab had open, and the settings of the last visit. @returns {Promise<Document>} */
async function begun() {
  const kept = loadMachines()
  const { settings, before } = await loadSettings({ ...form, presets: [...form.presets, ...kept] }, termFields, mostCurves())
  const { programs, selected, recordings, recording, calibration, sample } = keptOpen
  const start = [...form.presets, ...kept].find(({ name }) => name === settings.preset) ?? form.presets[0]
  return {
    programs,
    selected,
    recordings,
    recording,
    start: start.name,
    values: { ...(settings.values ?? start.values) },
    kept,
    tolerances: settings.tolerances ?? [...usualTolerances()],
    programmed: settings.programmed ?? true,
    quoted: settings.quoted ?? '',
    terms: settings.terms ?? {},
    lengthUnit: settings.lengthUnit ?? form.lengths[0].word,
    job: keptOpen.job,
    fixture: keptOpen.fixture,
    letter: keptOpen.letter,
    company: settings.company ?? {},
    beside: settings.beside ?? null,
    calibration,
    sample,
    beforeSettings: before,
  }
}

/** Shows lengths in the unit that is chosen. */
function showLengths() {
  showLengthsIn(form.lengths.find(({ word }) => word === store.now.lengthUnit) ?? form.lengths[0])
}

/** What is asked of the document, and what passes without leaving a trace in it. */
const machineOf = machineActions(store)
const actions = {
  ...machineOf,
  ...programActions(store, { reveal: () => opened.reveal('recording', () => Boolean(recordingOf(state)?.match)), hurry: () => changed(0) }),
  /** Calibrates the machine from all recordings that are used. */
  calibrate() {
    state.diagnosing = false
    state.calibrating = true
    engine.cancel()
    changed()
  },
  /** Says what was left out of the machine, from all recordings that are used. */
  diagnose() {
    state.calibrating = false
    state.diagnosing = true
    engine.cancel()
    opened.reveal('diagnosis', () => !state.diagnosing && state.diagnosis !== null)
    changed()
  },
  /** A program, its machine and a recording of a run that was slow: why, is found by itself. @param {{machine: string, program: {name: string, file: Blob}, recording: {name: string, bytes: Uint8Array}}} demo */
  async addSample({ machine, program, recording }) {
    const { valuesOfFile } = await whole()
    actions.addDemo(JSON.parse(valuesOfFile(machine)), program, recording)
    actions.diagnose()
  },
  /** Opens a job; programs that it only names are among the other files. @param {File} file @param {File[]} beside */
  addJob: async (file, beside) => (await second()).jobs.take(file, beside),
  /** @param {File} file */
  addMachine: (file) => machine.take(file),
  /** @param {File} file */
  addSettings: (file) => exchange.takeFile(file),
  /** Says why something is not taken; nothing takes that back. @param {string} message */
  refuse: (message) => exchange.refuse(message),
  /** @param {Pick<Place, 'distance_mm'>} place */
  show(place) {
    second().then(({ path }) => path.keep(place.distance_mm))
    chart.show(place)
  },
  /** Shows a stretch of the path (mm) in the charts, where they are. @param {[number, number]} stretch */
  reveal: (stretch) => chart.reveal(stretch),
  /** The same on the path as well. @param {[number, number]} stretch */
  mark(stretch) {
    second().then(({ path }) => path.keep(stretch))
    chart.reveal(stretch)
  },
  /** Opens a panel below the picture. @param {string} id */
  openPanel: (id) => opened.open(id),
  /** Adds a tolerance that was pointed at, or says why not. @param {number} tolerance  mm */
  addTolerance: (tolerance) => tolerances.choose(tolerance),
  /** What a cut asks of tool and spindle, for the breakdown. @param {Cut | null} cut */
  setCut(cut) {
    if (cut === state.cut) return
    state.cut = cut
    update()
  },
  /** How the program in sight differs from that of another job, for its path. @param {Revised | null} revised */
  setRevised(revised) {
    if (revised === state.revised) return
    state.revised = revised
    update()
  },
  undo: () => store.undo(),
  redo: () => store.redo(),
  cancel() {
    // Who stops a calibration or a diagnosis wants the machine as it is, and its results.
    const isAsked = state.calibrating || state.diagnosing
    state.calibrating = false
    state.diagnosing = false
    state.paused = !isAsked
    engine.cancel()
    if (isAsked) changed()
    else update()
  },
  resume: () => changed(),
}

/** What results depend on. @type {(keyof Document)[]} */
const CONCERN = ['programs', 'recordings', 'values', 'tolerances', 'programmed']

/** The document, or what is in sight of it, is another one. @param {Document} before @param {string | undefined} motion  of the machine before */
function heard(before, motion) {
  const { now } = store
  const running = state.progress?.program
  const reads = (/** @type {Document} */ { programs }) => {
    const program = programs.find(({ id }) => id === running)
    return program && [program.dialect, program.machine?.values].map((one) => JSON.stringify(one)).join()
  }
  if (motion !== state.machine.motion || (running && reads(before) !== reads(now))) engine.cancel()
  if (before.lengthUnit !== now.lengthUnit) showLengths()
  if (before.kept !== now.kept) saveMachines(now.kept)
  if (before.beforeSettings !== now.beforeSettings) saveBefore(now.beforeSettings)
  saveSettings({
    programmed: now.programmed,
    tolerances: [...now.tolerances],
    preset: now.start,
    values: now.values,
    terms: state.terms.values,
    company: now.company,
    beside: now.beside ?? undefined,
    quoted: now.quoted,
    lengthUnit: now.lengthUnit,
  })
  if (CONCERN.some((key) => before[key] !== now[key])) changed()
  else update()
}

/** Something that results depend on has changed: shows it at once, and computes when it has settled. @param {number} settles  ms */
function changed(settles = DEBOUNCE_MS) {
  state.paused = false
  failure.hidden = true
  update()
  clearTimeout(timer)
  timer = window.setTimeout(work, settles)
}

const progress = progressPanel.mount(element('progress'), actions)
const chart = chartPanel.mount(element('chart'))
const opened = openedPanel.mount(element('more'), element('opened'), shown)
/** A panel is opened: what it lacks comes. @param {string[]} ids */
function shown(ids) {
  if (ids.includes('savings')) second().then(({ savings }) => savings.update(state))
  // Machines are compared with each other: another one is chosen where none is.
  const other = form.presets.findIndex((_, index) => index !== state.machine.preset)
  if (ids.includes('compare') && state.beside === null && state.programs.length > 0) actions.setBeside(other)
}
const work = workOn(state, engine, {
  update,
  progress: () => progress.update(state),
  fail,
  hasCurve: () => whenIdle(second),
  paired: (recording, program) => actions.paired(recording, program),
  now: machineOf.inForm,
  take: machineOf.take,
})
const exchange = settingsPanel.mount(element('settings'), element('notice'), form.lengths, actions)
const machine = machinePanel.mount(element('machine'), form, actions)
const tolerances = tolerancesPanel.mount(element('tolerances'), { most: mostCurves(), usual: [...usualTolerances()] }, actions)
/** @type {{update(state: State): void}[]} */
const panels = [
  progress,
  historyPanel.mount(element('history'), store.history, actions),
  programPanel.mount(element('program'), JSON.parse(dialects()), JSON.parse(arcCenters()), actions),
  machine,
  tolerances,
  barPanel.mount(element('bar'), form),
  resultsPanel.mount(element('results'), actions),
  chart,
  recordingPanel.mount(element('recording'), actions),
  exchange,
  diagnosticsPanel.mount(element('diagnostics'), element('more')),
]

element('jobs').addEventListener('beforetoggle', () => second())

/** Prices the job; there once the whole module is. @type {(state: State) => State["price"]} */
let priceOf = () => null

/** The panels that can wait for the first chart. @type {Promise<{path: ReturnType<typeof import("./panels/path.js").mount>, jobs: ReturnType<typeof import("./panels/jobs.js").mount>, savings: ReturnType<typeof import("./panels/savings.js").mount>}> | undefined} */
let others

/** Mounts what can wait, once, with the whole module; from then on that computes as well. */
function second() {
  others ??= mountOthers().catch((error) => {
    others = undefined
    throw error
  })
  return others
}

async function mountOthers() {
  // What these draw and compute with is there before they are.
  const [compiled] = await Promise.all([wholeModule(), whole()])
  engine.prefer(compiled)
  engine.warm()
  const { against, breakdown, calibration, compare, cutting, diagnosis, job, jobs, letter, path, quote, savings, pricing, jobActions } = await import('./panels/later.js')
  const newEngine = () => new Engine(compiled, confinedWorker, wholeModule)
  const ofJob = { ...jobActions(store, { nextId: actions.nextId, hurry: () => changed(0) }), refuse: actions.refuse, update }
  const columnOf = (/** @type {Program} */ program) => quotedColumn(state, program)
  const other = against.mount(element('against'), newEngine(), form, actions)
  const compared = (/** @type {string} */ id) => {
    opened.open('against')
    other.withKept(id)
  }
  const own = {
    path: path.mount(element('path'), actions),
    jobs: jobs.mount(element('jobs'), form, columnOf, { ...ofJob, compare: compared }),
    savings: savings.mount(element('savings'), newEngine(), { ...actions, ...ofJob }),
  }
  panels.push(
    compare.mount(element('compare'), newEngine(), form, actions),
    other,
    own.path,
    own.jobs,
    own.savings,
    job.mount(element('program'), form, ofJob),
    letter.mount(element('letter'), ofJob),
    calibration.mount(element('calibration'), actions),
    diagnosis.mount(element('diagnosis'), newEngine(), form, actions),
    breakdown.mount(element('breakdown'), actions),
    quote.mount(element('quote'), form, actions),
    cutting.mount(element('cutting'), newEngine(), actions),
  )
  priceOf = pricing()
  update()
  import('./stored.js').then((stored) => stored.deleteClosed())
  document.documentElement.dataset.whole = 'true'
  return own
}

/** Does something when the page has drawn and has nothing else to do. @param {() => void} what */
function whenIdle(what) {
  // A picture hears that it is in sight after the frame in which it appears.
  requestAnimationFrame(() => requestAnimationFrame(() => drawn().then(() => setTimeout(what))))
}

function update() {
  saveOpen(state)
  state.price = priceOf(state)
  const { classList } = document.body
  classList.toggle('has-programs', state.programs.length > 0)
  classList.toggle('has-recording', recordingOf(state) !== undefined)
  classList.toggle('moves-nothing', isStill(programInSight(state)?.outcome))
  classList.toggle('is-job', isJob(state) && state.programs.some(({ outcome }) => outcome && !isStill(outcome)))
  for (const panel of panels) panel.update(state)
  // What there is to open depends on what the panels show.
  opened.update()
}

if (state.programs.length + state.recordings.length > 0) changed()
update()
await exchange.fromAddress()
document.documentElement.dataset.ready = 'true'
// Nobody listened to what was chosen while the page was loading.
for (const input of /** @type {NodeListOf<HTMLInputElement>} */ (document.querySelectorAll('input[type=file]'))) if (input.files?.length) input.dispatchEvent(new Event('change'))
// Who has read the page so far has a program at hand.
whenIdle(() => engine.warm())
