// The list of programs: adding by file, drop or sample, choosing one, removing with undo.

import { fileKind, sniffedBytes } from '../pkg/truefeed.js'
import { cycleOf, isStill, quotedColumn } from '../columns.js'
import { find, make, write } from '../dom.js'
import { clock, count, size } from '../format.js'
import { sample } from '../samples.js'
import { say } from '../texts.js'
import { mountUndo } from '../undo.js'
import { whole } from '../whole.js'
import { isDoubtful } from './results.js'

/** @import { Program, State } from "../types.js" */

const SAMPLE = 'pocket.nc'
/** A job and its programs. */
const JOB = ['bracket.json', 'bracket-10.nc', 'bracket-20.nc', 'bracket-30.nc']

/**
 * @typedef {object} Actions
 * @property {(files: {name: string, file: Blob}[], called?: string) => void} addPrograms
 * @property {(files: {name: string, bytes: Uint8Array}[]) => void} addRecordings
 * @property {(file: File) => Promise<void>} addMachine
 * @property {(file: File) => Promise<void>} addSettings
 * @property {(file: File, beside: File[]) => Promise<void>} addJob
 * @property {(message: string) => void} refuse
 * @property {(id: number) => void} select
 * @property {(id: number, dialect: string | null) => void} setDialect
 * @property {(id: number) => import('../state/store.js').Step} removeProgram
 */

/** @typedef {{word: string, name: string}[]} Words */

/** @param {HTMLElement} root @param {Words} dialects @param {Words} arcCenters @param {Actions} actions */
export function mount(root, dialects, arcCenters, actions) {
  const dialect = /** @type {HTMLSelectElement} */ (find(root, '#dialect'))
  const centers = /** @type {HTMLSelectElement} */ (find(root, '#arc-centers'))
  centers.append(make('option', { value: '' }, say.program.automatic), ...arcCenters.map(({ word, name }) => make('option', { value: word }, name)))
  const automatic = make('option', { value: '' })
  dialect.append(automatic, ...dialects.map(({ word, name }) => make('option', { value: word }, name)))
  /** @type {number | null} */
  let selected = null
  /** @type {Program[]} */
  let programs = []
  // How a program is read is both words together.
  for (const select of [dialect, centers]) {
    select.addEventListener('change', () => {
      if (selected !== null) actions.setDialect(selected, `${dialect.value} ${centers.value}`.trim() || null)
    })
  }
  const list = find(root, '.programs')
  const input = /** @type {HTMLInputElement} */ (find(document.body, '#files'))
  const undo = mountUndo(find(root, '.undo'))
  /** What had the focus is out of sight. */
  const focusSelected = () => /** @type {HTMLElement | null} */ (list.querySelector('[aria-selected=true]'))?.focus({ preventScroll: true })
  find(root, '.undo button').addEventListener('click', focusSelected)

  input.addEventListener('change', async () => {
    await add([...(input.files ?? [])].map(alone), actions)
    input.value = ''
  })
  for (const button of document.querySelectorAll('.sample')) {
    button.addEventListener('click', async () => {
      actions.addPrograms([{ name: say.program.sample, file: await sample(SAMPLE) }])
      if (button.closest('#welcome')) focusSelected()
    })
  }
  for (const button of document.querySelectorAll('.sample-job')) {
    button.addEventListener('click', async () => {
      const [job, ...beside] = await Promise.all(JOB.map(sample))
      await actions.addJob(job, beside)
      if (button.closest('#welcome')) focusSelected()
    })
  }
  find(root, '.remove-selected').addEventListener('click', () => {
    const program = programs.find(({ id }) => id === selected)
    if (program) remove(program)
  })
  acceptDrops(actions)

  /** @param {Pick<Program, 'id' | 'name'>} program */
  function remove({ id, name }) {
    undo.offer(say.common.removed(name), actions.removeProgram(id))
    // Without a program the list is out of sight.
    find(document.body, programs.length > 0 ? '#program .undo button' : '.undo-change').focus()
  }

  /** What is in the list, by program; kept, so that nobody clicks on what is being replaced. @type {Map<number, Entry>} */
  const entries = new Map()

  /** @typedef {{item: HTMLElement, choose: HTMLElement, label: HTMLElement, about: HTMLElement}} Entry */
  /** Holds nothing of a program but its name: what was removed with the focus on it is kept by the browser for a while. @param {Program} program @returns {Entry} */
  function entry({ id, name }) {
    const about = make('span', { className: 'about' })
    const label = make('span', { className: 'file' })
    const choose = make('button', { type: 'button', className: 'choose', role: 'tab', title: say.program.removeByDelete }, label, about)
    choose.setAttribute('aria-controls', 'results')
    choose.addEventListener('click', () => actions.select(id))
    choose.addEventListener('keydown', (event) => {
      if (event.key === 'Delete') return remove({ id, name })
      const tabs = /** @type {HTMLElement[]} */ ([...list.querySelectorAll('.choose')])
      const here = tabs.indexOf(choose)
      /** @type {Record<string, number>} */
      const places = { ArrowUp: here - 1, ArrowLeft: here - 1, ArrowDown: here + 1, ArrowRight: here + 1, Home: 0, End: tabs.length - 1 }
      if (!(event.key in places)) return
      event.preventDefault()
      const next = tabs[(places[event.key] + tabs.length) % tabs.length]
      next.click()
      next.focus()
    })
    const removal = make('button', { type: 'button', className: 'remove', title: say.common.remove }, '×')
    // A list of tabs holds nothing else: this is for the pointer, Delete and the button below are for everyone.
    removal.setAttribute('aria-hidden', 'true')
    removal.tabIndex = -1
    removal.addEventListener('click', () => remove({ id, name }))
    return { item: make('li', { role: 'presentation' }, choose, removal), choose, label, about }
  }

  return {
    /** @param {State} state */
    update(state) {
      undo.update()
      programs = state.programs
      const current = programs.find(({ id }) => id === state.selected)
      selected = current?.id ?? null
      const found = dialects.find(({ word }) => word === current?.outcome?.summary.dialect)
      const words = current?.dialect?.split(' ') ?? []
      const chosen = (/** @type {Words} */ all) => all.find(({ word }) => words.includes(word))?.word ?? ''
      if (!chosen(dialects)) automatic.textContent = found ? say.program.automaticAs(found.name) : say.program.automatic
      dialect.value = chosen(dialects)
      centers.value = chosen(arcCenters)
      for (const [id, { item }] of entries) {
        if (state.programs.some((program) => program.id === id)) continue
        item.remove()
        entries.delete(id)
      }
      for (const [index, program] of state.programs.entries()) {
        const { item, choose, label, about } = entries.get(program.id) ?? entry(program)
        entries.set(program.id, { item, choose, label, about })
        if (list.children[index] !== item) list.insertBefore(item, list.children[index] ?? null)
        const called = program.title || program.found || program.name
        write(label, called)
        label.title = called === program.name ? called : `${called} (${program.name})`
        about.textContent = standing(program, state)
        const run = program.outcome?.runs.get(quotedColumn(state, program))?.summary
        about.classList.toggle('doubtful', Boolean(run && isDoubtful(run)))
        const isSelected = program.id === state.selected
        choose.setAttribute('aria-selected', String(isSelected))
        choose.tabIndex = isSelected ? 0 : -1
      }
    },
  }
}

/** One line on how a program stands. @param {Program} program @param {State} state */
function standing(program, state) {
  if (state.progress?.program === program.id) return say.program.computing
  if (program.failure) return say.program.failed
  if (isStill(program.outcome)) return say.program.still
  const cycle = cycleOf(state, program)
  if (cycle === undefined) return program.outcome ? say.program.computing : say.program.waiting(size(program.file.size))
  const errors = program.outcome?.summary.diagnostics.filter(({ severity }) => severity === 'error').length ?? 0
  return errors > 0 ? say.program.errors(errors, clock(cycle), count(errors)) : clock(cycle)
}

/** Reads files. @param {File[]} files */
export async function bytesOf(files) {
  const read = async (/** @type {File} */ file) => ({
    name: file.name,
    bytes: new Uint8Array(await file.arrayBuffer()),
  })
  const results = await Promise.allSettled(files.map(read))
  return results.flatMap((result) => (result.status === 'fulfilled' ? [result.value] : []))
}

/** Files up to this size are kept as they are now; larger ones are read again where they are. Bytes. */
const KEPT = 16_000_000

/** What was found of a drop; `named`: it was dropped itself, and not a folder or an archive that it is in. @typedef {{file: File, named: boolean, path?: string}} Found */

/** @param {File} file @returns {Found} */
const alone = (file) => ({ file, named: true })

/** The folder or archive that all these are in, without its ending; empty where there is none. @param {{path: string, named: boolean}[]} found */
function containerOf(found) {
  const all = new Set(found.map(({ path, named }) => (named ? '' : path.split('/')[0])))
  return all.size === 1 ? [...all][0].replace(/\.zip$/i, '') : ''
}

/** Those texts of folders and archives that hold no blocks, as a read-me. @template {{file: File}} T @param {T[]} texts */
async function withoutBlocks(texts) {
  if (texts.length === 0) return []
  const { holdsBlocks } = await whole()
  const isNone = await Promise.all(texts.map(async ({ file }) => !holdsBlocks(new Uint8Array(await file.slice(0, sniffedBytes()).arrayBuffer()))))
  return texts.filter((_, index) => isNone[index])
}

/** Takes machines by their names and all else by what stands in it, and says what is of no use. @param {Found[]} dropped @param {Actions} actions @param {string[]} told  what else is of no use */
async function add(dropped, actions, told = []) {
  const isMachine = (/** @type {Found} */ { file: { name }, named }) => named && /\.toml$/i.test(name)
  const headed = async (/** @type {Found} */ { file, named, path = file.name }) => ({
    file,
    named,
    path,
    // A table of which nothing can be read is a recording too, which says why not.
    kind: /\.csv$/i.test(file.name) ? 'recording' : fileKind(new Uint8Array(await file.slice(0, sniffedBytes()).arrayBuffer())),
    kept: file.size <= KEPT ? new Blob([await file.arrayBuffer()]) : file,
  })
  // op2 comes before op10.
  const files = dropped.filter((found) => !isMachine(found)).sort((a, b) => a.file.name.localeCompare(b.file.name, 'en', { numeric: true }))
  const results = await Promise.allSettled(files.map(headed))
  const all = results.flatMap((result) => (result.status === 'fulfilled' ? [result.value] : []))
  // An archive in an archive stays shut.
  const archives = all.filter(({ kind, named }) => kind === 'archive' && named)
  if (archives.length > 0) {
    const { unpacked } = await import('../job/archive.js')
    /** @type {string[]} */
    const refused = []
    const inside = await Promise.all(archives.map(({ file }) => unpacked(file, (message) => refused.push(message))))
    return add([...dropped.filter(({ file }) => archives.every((archive) => archive.file !== file)), ...inside.flat()], actions, refused)
  }
  for (const { file } of dropped.filter(isMachine)) await actions.addMachine(file)
  const job = all.find(({ kind }) => kind === 'job')
  if (job)
    return actions.addJob(
      job.file,
      all.flatMap(({ file }) => (file === job.file ? [] : [file])),
    )
  const of = (/** @type {string} */ wanted) => all.filter(({ kind }) => kind === wanted)
  const texts = await withoutBlocks(of('program').filter(({ named }) => !named))
  const programs = of('program')
    .filter((one) => !texts.includes(one))
    .map(({ file, kept }) => ({ name: file.name, file: kept }))
  const recordings = await bytesOf(of('recording').map(({ file }) => file))
  const others = all.filter(({ kind, named }) => named && !['program', 'recording', 'settings'].includes(kind))
  const leftOut = texts.length > 0 ? [say.program.leftOut(texts.map(({ file }) => file.name).join(', '))] : []
  actions.refuse([...told, ...leftOut, ...others.map(({ file, kind }) => say.program.notTaken(file.name, kind))].join(' '))
  for (const { file } of of('settings')) await actions.addSettings(file)
  if (programs.length > 0) actions.addPrograms(programs, containerOf(of('program')))
  if (recordings.length > 0) actions.addRecordings(recordings)
}

/** Files may be dropped anywhere on the page. @param {Actions} actions */
function acceptDrops(actions) {
  const cover = find(document.body, '.cover')
  const carriesFiles = (/** @type {DragEvent} */ event) => event.dataTransfer?.types.includes('Files') ?? false
  let depth = 0
  const show = (/** @type {number} */ change) => {
    depth = Math.max(0, depth + change)
    cover.hidden = depth === 0
  }
  document.addEventListener('dragenter', (event) => carriesFiles(event) && show(1))
  document.addEventListener('dragleave', (event) => carriesFiles(event) && show(-1))
  document.addEventListener('dragover', (event) => carriesFiles(event) && event.preventDefault())
  document.addEventListener('drop', (event) => {
    if (!carriesFiles(event)) return
    event.preventDefault()
    show(-depth)
    // Nothing of a drop is left after it is handled.
    const items = [...(event.dataTransfer?.items ?? [])].filter(({ kind }) => kind === 'file')
    addDropped(items.map((item) => ({ entry: item.webkitGetAsEntry?.() ?? null, file: item.getAsFile() })))
  })

  /** @param {{entry: FileSystemEntry | null, file: File | null}[]} dropped */
  async function addDropped(dropped) {
    const hasFolder = dropped.some(({ entry }) => entry?.isDirectory)
    const files = hasFolder ? await (await import('../job/dropped.js')).filesOf(dropped) : dropped.flatMap(({ file }) => (file ? [alone(file)] : []))
    await add(files, actions, hasFolder && files.length === 0 ? [say.program.emptyFolder] : [])
  }
}
