// The machine: presets and those kept in the browser, and the editor of every parameter, built from the table of the module.

import { find, make } from '../dom.js'
import { field, same } from '../field.js'
import { roughly, worded } from '../format.js'
import { say } from '../texts.js'
import { mountUndo } from '../undo.js'

/** @import { Entry } from "../field.js" */
/** @import { Step } from "../state/store.js" */
/** @import { Form, Preset, State, Value, Values } from "../types.js" */

/** The parameters an estimator meets first: those of a data sheet, then those of the control. All others are under “More parameters”. */
const BASIC = ['name', 'rapid.feed_mm_min', 'path.acceleration_mm_s2', 'times.tool_change_s', 'rates.hourly', 'interpolator.corner_mode', 'interpolator.filters', 'interpolator.time_constant_s']

/**
 * @typedef {object} Actions
 * @property {(index: number) => void} choosePreset
 * @property {(key: string, value: Value) => void} setParameter
 * @property {() => Step} keepMachine
 * @property {() => Step} duplicateMachine
 * @property {() => Step} removeMachine
 * @property {(text: string) => Promise<Step>} importMachine
 * @property {(name: string, recording: Uint8Array) => Promise<{sentence: string, step: Step}>} takeMove
 */

/** @param {HTMLElement} root @param {Form} form @param {Actions} actions */
export function mount(root, form, actions) {
  const preset = /** @type {HTMLSelectElement} */ (find(root, '#preset'))
  const button = (/** @type {string} */ name) => /** @type {HTMLButtonElement} */ (find(root, name))
  const [reset, save, keep, duplicate, remove] = ['.reset', '.save', '.keep', '.duplicate', '.remove'].map(button)
  const file = /** @type {HTMLInputElement} */ (find(root, '#machine-file'))
  const move = make('input', { id: 'machine-move', type: 'file', className: 'away', accept: '.csv,.txt,.log,.gz,.zip,text/*' })
  const moved = make('p', { className: 'moved', role: 'status' })
  const more = /** @type {HTMLDetailsElement} */ (find(root, 'details'))
  const search = /** @type {HTMLInputElement} */ (find(root, '.search input[type="search"]'))
  const onlySet = /** @type {HTMLInputElement} */ (find(root, '.search input[type="checkbox"]'))
  const found = find(root, '.found')
  const fault = find(root, '.import-fault')
  const fields = form.fields.map((parameter) => field('field', parameter, actions.setParameter))
  const undo = mountUndo(find(root, '.undo'))
  fault.after(moved)
  find(root, 'label[for="machine-file"]').after(move, make('label', { className: 'button', htmlFor: move.id }, say.machine.move))
  /** @type {Values} */
  let values = {}
  /** Those with the filters of a recorded move. @type {Values | undefined} */
  let taken
  /** The starts that are offered now. @type {string} */
  let offered = ''

  preset.addEventListener('change', () => actions.choosePreset(Number(preset.value)))
  reset.addEventListener('click', () => actions.choosePreset(Number(preset.value)))
  save.addEventListener('click', async () => (await import('../save.js')).saveMachine(values))
  keep.addEventListener('click', () => undo.offer(say.machine.kept, actions.keepMachine()))
  duplicate.addEventListener('click', () => undo.offer(say.machine.duplicated, actions.duplicateMachine()))
  remove.addEventListener('click', () => undo.offer(say.common.removed(values.name), actions.removeMachine()))
  file.addEventListener('change', async () => {
    const [chosen] = file.files ?? []
    if (!chosen) return
    await take(chosen)
    file.value = ''
  })
  move.addEventListener('change', async () => {
    const [chosen] = move.files ?? []
    if (!chosen) return
    await takeMove(chosen)
    move.value = ''
  })
  find(root, 'form').addEventListener('submit', (event) => event.preventDefault())

  const ofKey = new Map(fields.map((entry) => [entry.parameter.key, entry]))
  find(root, '.basic').append(...BASIC.flatMap((key) => ofKey.get(key)?.element ?? []))
  const rest = fields.filter(({ parameter }) => !BASIC.includes(parameter.key))
  const groups = groupsOf(rest)
  find(root, '.more').append(...groups.map(({ element }) => element))
  search.addEventListener('input', filter)
  onlySet.addEventListener('change', filter)

  /** Takes the machine of a file, or says why it is none. @param {File} chosen */
  async function take(chosen) {
    try {
      const step = await actions.importMachine(await chosen.text())
      fault.textContent = ''
      undo.offer(say.machine.loaded(chosen.name), step)
    } catch (reason) {
      fault.textContent = say.machine.notMachine(chosen.name, reason)
    }
  }

  /** Takes the filters of a recorded move, or says why there are none. @param {File} chosen */
  async function takeMove(chosen) {
    try {
      const { sentence, step } = await actions.takeMove(chosen.name, new Uint8Array(await chosen.arrayBuffer()))
      fault.textContent = ''
      moved.textContent = worded(sentence)
      taken = values
      undo.offer(`${say.machine.move}: ${chosen.name}`, step)
    } catch (reason) {
      moved.textContent = ''
      fault.textContent = reason instanceof Error ? reason.message : String(reason)
    }
  }

  /** Shows the fields that are looked for. */
  function filter() {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean)
    let count = 0
    for (const { element, title, entries } of groups) {
      let shown = 0
      for (const { parameter, element: own } of entries) {
        const { key, label, doc, unit } = parameter
        const text = `${key} ${label} ${doc} ${unit ?? ''} ${title}`.toLowerCase()
        const isMeant = words.every((word) => text.includes(word)) && (!onlySet.checked || own.classList.contains('set'))
        own.hidden = !isMeant
        if (isMeant) shown += 1
      }
      element.hidden = shown === 0
      count += shown
    }
    const isAll = words.length === 0 && !onlySet.checked
    found.textContent = isAll ? '' : count === 0 ? say.machine.none : say.machine.foundOf(count, rest.length)
  }

  /** The starts as options: presets, then those kept. @param {string} names */
  function offer(names) {
    if (names === offered) return
    offered = names
    const option = (/** @type {Preset} */ { name }, /** @type {number} */ index) => make('option', { value: String(index) }, name)
    const options = form.presets.map((entry, index) => ({ entry, option: option(entry, index) }))
    const group = (/** @type {string} */ label, /** @type {boolean} */ kept) => {
      const own = options.filter(({ entry }) => Boolean(entry.kept) === kept)
      return own.length > 0 ? [make('optgroup', { label }, ...own.map(({ option }) => option))] : []
    }
    preset.replaceChildren(...group(say.machine.presets, false), ...group(say.machine.keptHere, true))
  }

  return {
    take,
    /** @param {State} state */
    update({ machine, calibration }) {
      undo.update()
      values = machine.values
      if (taken && !same(values, taken)) {
        taken = undefined
        moved.textContent = ''
      }
      const start = form.presets[machine.preset]
      offer(JSON.stringify(form.presets.map(({ name }) => name)))
      preset.value = String(machine.preset)
      preset.title = start.name
      find(root, '.source').textContent = worded(`${start.source} ${start.caveat}`.trim())
      find(root, '.origin').textContent = originOf(values, Boolean(start.kept || calibration))
      const isChanged = !same(values, start.values)
      save.disabled = machine.faults.length > 0
      keep.disabled = machine.faults.length > 0 || (Boolean(start.kept) && !isChanged)
      keep.textContent = start.kept ? say.machine.keepChanges : say.machine.keep
      duplicate.disabled = machine.faults.length > 0
      remove.hidden = !start.kept
      reset.disabled = !isChanged
      reset.textContent = start.kept ? say.machine.resetKept : say.machine.resetPreset
      for (const { parameter, element, show } of fields) {
        const message = machine.faults.find(({ key }) => key === parameter.key)?.message ?? ''
        show(values[parameter.key] ?? null, message)
        element.classList.toggle('changed', !same(values[parameter.key], start.values[parameter.key]))
        if (message && more.contains(element)) {
          more.open = true
          element.hidden = false
        }
      }
      const count = rest.filter(({ element }) => element.classList.contains('set')).length
      find(root, '.count').textContent = count > 0 ? say.machine.inUse(count) : ''
      const elsewhere = machine.faults.filter(({ key }) => key === null || !ofKey.has(key)).map(({ message }) => message)
      find(root, '.faults').textContent = elsewhere.join(' ')
    },
  }
}

/** Where the numbers of a machine come from and how exact they are. @param {Values} values @param {boolean} isOwn  the user's, and no preset */
function originOf({ provenance, 'calibration.cycle_time_error_percent': error }, isOwn) {
  if (!provenance) return ''
  if (typeof error === 'number' && !isOwn) return say.machine.testedOn(roughly(error), provenance)
  return say.machine.origin(provenance, typeof error === 'number' ? say.machine.calibratedTo(roughly(error)) : '')
}

/** Fields by their group, in the order of the first of each. @param {Entry[]} entries */
function groupsOf(entries) {
  const titles = [...new Set(entries.map(({ parameter }) => parameter.group))]
  return titles.map((title) => {
    const own = entries.filter(({ parameter }) => parameter.group === title)
    const legend = make('legend', {}, title)
    return { title, entries: own, element: make('fieldset', {}, legend, ...own.map(({ element }) => element)) }
  })
}
