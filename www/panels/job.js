// The operations of a job: their order, their names, and what each has of its own; the time of a part together.

import { programTitle, sniffedBytes, termsForm, toolsOf } from '../pkg/truefeed_whole.js'
import { columnLabel, columnsOf, isJob, programInSight, quotedColumn } from '../columns.js'
import { find, make, offer, write } from '../dom.js'
import { field } from '../field.js'
import { clock } from '../format.js'
import { keepHead, nameOf } from '../job/names.js'
import { say } from '../texts_later.js'

/** @import { OfOperation } from "../job/document.js" */
/** @import { Form, OwnTolerance, Parameter, Program, State, Value } from "../types.js" */

const RATE = 'rates.hourly'
/** What is dragged is an operation, and no file. */
const DRAGGED = 'application/x-truefeed-operation'

/**
 * @typedef {object} Actions
 * @property {(id: number, what: Partial<OfOperation>) => unknown} setOperation
 * @property {(id: number, to: number) => void} moveProgram
 * @property {() => void} update
 */

/** @param {HTMLElement} root  the programs @param {Form} form @param {Actions} actions */
export function mount(root, form, actions) {
  const list = find(root, '.programs')
  /** @type {State | undefined} */
  let state
  /** The one whose own values are in sight. @type {Program | undefined} */
  let current

  const total = make('p', { className: 'total', hidden: true })
  const name = make('input', { id: 'operation-name', maxLength: 200 })
  const machine = make('select', { id: 'operation-machine' })
  const tolerance = make('select', { id: 'operation-tolerance' })
  const up = make('button', { type: 'button', className: 'up', title: say.job.upKey }, say.job.up)
  const down = make('button', { type: 'button', className: 'down', title: say.job.downKey }, say.job.down)
  const change = (/** @type {Partial<OfOperation>} */ what) => current && actions.setOperation(current.id, what)
  /** @type {Parameter[]} */
  const terms = JSON.parse(termsForm())
  const own = (/** @type {string} */ key) => ({ .../** @type {Parameter} */ (terms.find((term) => term.key === key)), neutral: null })
  const rate = field('operation', { .../** @type {Parameter} */ (form.fields.find(({ key }) => key === RATE)), label: say.job.rate }, (key, value) => {
    if (current?.machine) change({ machine: { start: current.machine.start, values: { ...current.machine.values, [key]: value } } })
  })
  const setUp = field('operation', own('set_up_min'), (_, value) => change({ setUp: numberOf(value) }))
  const loading = field('operation', own('loading_s'), (_, value) => change({ loading: numberOf(value) }))
  const details = make(
    'details',
    { className: 'operation' },
    make('summary', {}, say.job.operation),
    line(say.job.name, name),
    line(say.job.machine, machine),
    rate.element,
    line(say.job.tolerance, tolerance),
    setUp.element,
    loading.element,
    make('p', { className: 'choices' }, up, down),
  )
  list.after(total, details)

  name.addEventListener('change', () => change({ title: name.value.trim() }))
  machine.addEventListener('change', () => {
    const preset = form.presets.find((one) => one.name === machine.value)
    change({ machine: preset ? { start: preset.name, values: { ...preset.values } } : null })
  })
  tolerance.addEventListener('change', () => change({ tolerance: toleranceOf(tolerance.value) }))
  up.addEventListener('click', () => step(-1))
  down.addEventListener('click', () => step(1))

  /** Moves the operation in sight. @param {number} places */
  function step(places) {
    const at = state && current ? state.programs.indexOf(current) : -1
    if (current && at >= 0) actions.moveProgram(current.id, at + places)
  }

  // Keys of the list: before it goes to another operation by the same arrows.
  list.addEventListener(
    'keydown',
    (event) => {
      const places = event.altKey ? { ArrowUp: -1, ArrowDown: 1 }[event.key] : undefined
      if (places !== undefined) {
        step(places)
        list.querySelector(/** @type {any} */ ('[aria-selected=true]'))?.focus()
      } else if (event.key === 'F2') rename()
      else return
      event.preventDefault()
      event.stopPropagation()
    },
    true,
  )
  list.addEventListener('dblclick', rename)

  /** Puts an input in the place of the name. */
  function rename() {
    const button = /** @type {HTMLElement | null} */ (list.querySelector('[aria-selected=true]'))
    const program = current
    if (!button || !program) return
    const input = make('input', { className: 'rename', value: nameOf(program), maxLength: 200 })
    input.setAttribute('aria-label', say.job.name)
    let isDone = false
    const end = (/** @type {boolean} */ isTaken) => {
      if (isDone) return
      isDone = true
      input.remove()
      button.hidden = false
      if (isTaken) actions.setOperation(program.id, { title: input.value.trim() })
      button.focus()
    }
    input.addEventListener('keydown', (event) => {
      if (event.key === 'Enter' || event.key === 'Escape') end(event.key === 'Enter')
      event.stopPropagation()
    })
    input.addEventListener('blur', () => end(true))
    button.hidden = true
    button.before(input)
    input.select()
  }

  // Order by dragging.
  list.addEventListener('dragstart', (event) => {
    const item = itemOf(event)
    if (!item || !event.dataTransfer) return
    event.dataTransfer.setData(DRAGGED, String([...list.children].indexOf(item)))
    event.dataTransfer.effectAllowed = 'move'
  })
  list.addEventListener('dragover', (event) => {
    if (!event.dataTransfer?.types.includes(DRAGGED)) return
    event.preventDefault()
    for (const item of list.children) item.classList.toggle('into', item === itemOf(event))
  })
  for (const kind of ['dragend', 'drop']) list.addEventListener(kind, () => list.querySelector('.into')?.classList.remove('into'))
  list.addEventListener('drop', (event) => {
    const item = itemOf(event)
    const from = event.dataTransfer?.getData(DRAGGED)
    if (!item || !from || !state) return
    event.preventDefault()
    actions.moveProgram(state.programs[Number(from)].id, [...list.children].indexOf(item))
  })

  /** @param {Event} event */
  const itemOf = ({ target }) => (target instanceof Element ? target.closest('li') : null)

  /** Programs whose heads are being read for what they call themselves. @type {WeakSet<Program>} */
  const asked = new WeakSet()

  /** Reads what programs call themselves. @param {Program[]} programs */
  async function findNames(programs) {
    const unknown = programs.filter((program) => !asked.has(program))
    for (const program of unknown) asked.add(program)
    const read = async (/** @type {Program} */ program) => {
      const head = new Uint8Array(await program.file.slice(0, sniffedBytes()).arrayBuffer())
      const said = { found: programTitle(head) ?? '', described: JSON.parse(toolsOf(head)) }
      keepHead(program.file, said)
      Object.assign(program, said)
    }
    await Promise.allSettled(unknown.map(read))
    if (unknown.length > 0) actions.update()
  }

  return {
    /** @param {State} now */
    update(now) {
      state = now
      current = programInSight(now)
      findNames(now.programs)
      for (const item of list.children) /** @type {HTMLElement} */ (item).draggable = now.programs.length > 1
      total.hidden = !isJob(now)
      const text = now.price ? say.job.total(clock(now.price.report.cycle_time_s)) : say.job.waiting
      write(total, text)
      details.hidden = !current
      if (!current) return
      const at = now.programs.indexOf(current)
      up.disabled = at === 0
      down.disabled = at === now.programs.length - 1
      if (document.activeElement !== name) name.value = current.title
      name.placeholder = current.found || current.name
      showMachines(current, now)
      showTolerances(current, now)
      rate.element.hidden = !current.machine
      rate.show(current.machine?.values[RATE] ?? null, faultOf(current, RATE))
      setUp.show(current.setUp, '')
      loading.show(current.loading, '')
    },
  }

  /** @param {Program} program @param {State} now */
  function showMachines(program, now) {
    offer(machine, [['', say.job.ofJob(String(now.machine.values.name ?? ''))], ...form.presets.map(({ name }) => [name, name])], program.machine?.start ?? '')
  }

  /** The tolerances that are compared, and its own where it is none of them. @param {Program} program @param {State} now */
  function showTolerances(program, now) {
    const ofJob = columnLabel(quotedColumn(now, { ...program, tolerance: null }))
    const isProgrammed = program.outcome?.held.length || program.tolerance === PROGRAMMED
    const columns = [...(isProgrammed ? [null] : []), ...columnsOf(now, program).filter((column) => column !== null)]
    const choices = columns.map((column) => [choiceOf(column), columnLabel(column)])
    offer(tolerance, [['', say.job.ofJob(ofJob)], ...choices], choiceOf(program.tolerance, ''))
  }
}

const PROGRAMMED = 'programmed'

/** A tolerance as the value of its choice. @param {OwnTolerance} tolerance @param {string} [none]  that of no tolerance */
const choiceOf = (tolerance, none = PROGRAMMED) => (tolerance === null ? none : String(tolerance))

/** A tolerance by the value of its choice. @param {string} value @returns {OwnTolerance} */
const toleranceOf = (value) => (value === '' ? null : value === PROGRAMMED ? value : Number(value))

/** What is wrong with a value of an operation's own machine. @param {Program} program @param {string} wanted */
const faultOf = ({ machine }, wanted) => machine?.faults.find(({ key }) => key === wanted)?.message ?? ''

/** A number, or nothing; what is no number is nothing. @param {Value} value */
const numberOf = (value) => (typeof value === 'number' ? value : null)

/** @param {string} label @param {HTMLElement} control */
const line = (label, control) => make('div', { className: 'field' }, make('label', { htmlFor: control.id }, label), make('span', { className: 'value' }, control))
