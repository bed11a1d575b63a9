// The list of programs: adding by file, drop or sample, choosing one, removing with undo.

import { fileKind, sniffedBytes } from '../pkg/truefeed.js'
import { columnsOf, isStill } from '../columns.js'
import { find, make } from '../dom.js'
import { clock, count, size } from '../format.js'
import { say } from '../texts.js'
import { mountUndo } from '../undo.js'

/** @import { Program, State } from "../types.js" */

const SAMPLE = 'samples/pocket.nc'

/**
 * @typedef {object} Actions
 * @property {(files: {name: string, file: Blob}[]) => void} addPrograms
 * @property {(files: {name: string, bytes: Uint8Array}[]) => void} addRecordings
 * @property {(file: File) => Promise<void>} addMachine
 * @property {(file: File) => Promise<void>} addSettings
 * @property {(message: string) => void} refuse
 * @property {(id: number) => void} select
 * @property {(id: number, dialect: string | null) => void} setDialect
 * @property {(id: number) => () => void} removeProgram
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
    await add([...(input.files ?? [])], actions)
    input.value = ''
  })
  for (const button of document.querySelectorAll('.sample')) {
    button.addEventListener('click', async () => {
      const response = await fetch(new URL(`../${SAMPLE}`, import.meta.url))
      actions.addPrograms([{ name: say.program.sample, file: await response.blob() }])
      if (button.closest('#welcome')) focusSelected()
    })
  }
  find(root, '.remove-selected').addEventListener('click', () => {
    const program = programs.find(({ id }) => id === selected)
    if (program) remove(program)
  })
  acceptDrops(actions)

  /** @param {Program} program */
  function remove(program) {
    undo.offer(say.common.removed(program.name), actions.removeProgram(program.id))
    // Without a program the list is out of sight.
    find(document.body, programs.length > 0 ? '#program .undo button' : '.undo-change').focus()
  }

  /** What is in the list, by program; kept, so that nobody clicks on what is being replaced. @type {Map<number, Entry>} */
  const entries = new Map()

  /** @typedef {{item: HTMLElement, choose: HTMLElement, about: HTMLElement}} Entry */
  /** @param {Program} program @returns {Entry} */
  function entry(program) {
    const about = make('span', { className: 'about' })
    const choose = make(
      'button',
      { type: 'button', className: 'choose', role: 'tab', title: say.program.removeByDelete },
      make('span', { className: 'file', title: program.name }, program.name),
      about,
    )
    choose.setAttribute('aria-controls', 'results')
    choose.addEventListener('click', () => actions.select(program.id))
    choose.addEventListener('keydown', (event) => {
      if (event.key === 'Delete') return remove(program)
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
    removal.addEventListener('click', () => remove(program))
    return { item: make('li', { role: 'presentation' }, choose, removal), choose, about }
  }

  return {
    /** @param {State} state */
    update(state) {
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
        const { item, choose, about } = entries.get(program.id) ?? entry(program)
        entries.set(program.id, { item, choose, about })
        if (list.children[index] !== item) list.insertBefore(item, list.children[index] ?? null)
        about.textContent = standing(program, state)
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
  const times = columnsOf(state, program.outcome).flatMap(
    (column) => program.outcome?.runs.get(column)?.summary.cycle_time_s ?? [],
  )
  if (times.length === 0) return say.program.waiting(size(program.file.size))
  const [longest, shortest] = [clock(Math.max(...times)), clock(Math.min(...times))]
  const errors = program.outcome?.summary.diagnostics.filter(({ severity }) => severity === 'error').length ?? 0
  const time = longest === shortest ? longest : `${shortest} – ${longest}`
  return errors > 0 ? say.program.errors(errors, time, count(errors)) : time
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

/** Takes machines by their names and all else by what stands in it, and says what is of no use. @param {File[]} dropped @param {Actions} actions */
async function add(dropped, actions) {
  const isMachine = (/** @type {File} */ { name }) => /\.toml$/i.test(name)
  for (const file of dropped.filter(isMachine)) await actions.addMachine(file)
  const files = dropped.filter((file) => !isMachine(file))
  const headed = async (/** @type {File} */ file) => ({
    file,
    // A table of which nothing can be read is a recording too, which says why not.
    kind: /\.csv$/i.test(file.name) ? 'recording' : fileKind(new Uint8Array(await file.slice(0, sniffedBytes()).arrayBuffer())),
    kept: file.size <= KEPT ? new Blob([await file.arrayBuffer()]) : file,
  })
  const results = await Promise.allSettled(files.map(headed))
  const all = results.flatMap((result) => (result.status === 'fulfilled' ? [result.value] : []))
  const of = (/** @type {string} */ wanted) => all.filter(({ kind }) => kind === wanted)
  const programs = of('program').map(({ file, kept }) => ({ name: file.name, file: kept }))
  const recordings = await bytesOf(of('recording').map(({ file }) => file))
  const others = all.filter(({ kind }) => !['program', 'recording', 'settings'].includes(kind))
  actions.refuse(others.map(({ file, kind }) => say.program.notTaken(file.name, kind)).join(' '))
  for (const { file } of of('settings')) await actions.addSettings(file)
  if (programs.length > 0) actions.addPrograms(programs)
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
    add([...(event.dataTransfer?.files ?? [])], actions)
  })
}
