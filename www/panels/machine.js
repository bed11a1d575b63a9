// The machine form, built from the parameter table of the module. It keeps texts and passes values on; what they
// mean and whether they are allowed is for Rust to say.

import { find, make } from '../dom.js'
import { saveMachine } from '../save.js'

/** @import { Form, Parameter, State, Value, Values } from "../types.js" */

/** The parameters an estimator meets first; all others are under “More parameters”. */
const BASIC = [
  'interpolator.filters',
  'interpolator.time_constant_s',
  'interpolator.corner_mode',
  'rapid.feed_mm_min',
  'times.tool_change_s',
  'rates.hourly',
]
/** The tolerance is chosen by its chips. */
const ELSEWHERE = ['interpolator.contour_tolerance_mm']

/**
 * @param {HTMLElement} root
 * @param {Form} form
 * @param {{choosePreset(index: number): void, setParameter(key: string, value: Value): void}} actions
 */
export function mount(root, form, actions) {
  const preset = /** @type {HTMLSelectElement} */ (find(root, '#preset'))
  const reset = /** @type {HTMLButtonElement} */ (find(root, '.reset'))
  const save = /** @type {HTMLButtonElement} */ (find(root, '.save'))
  const more = /** @type {HTMLDetailsElement} */ (find(root, 'details'))
  const parameters = form.fields.filter(({ key }) => !ELSEWHERE.includes(key))
  const fields = parameters.map((parameter) => field(parameter, actions.setParameter))
  /** @type {Values} */
  let values = {}

  preset.append(...form.presets.map(({ name }, index) => make('option', { value: String(index) }, name)))
  preset.addEventListener('change', () => actions.choosePreset(Number(preset.value)))
  reset.addEventListener('click', () => actions.choosePreset(Number(preset.value)))
  save.addEventListener('click', () => saveMachine(values))
  find(root, 'form').addEventListener('submit', (event) => event.preventDefault())
  const byKey = new Map(fields.map((entry) => [entry.parameter.key, entry.element]))
  const present = (/** @type {string} */ key) => byKey.get(key) ?? []
  find(root, '.basic').append(...BASIC.flatMap(present))
  find(root, '.more').append(...parameters.filter(({ key }) => !BASIC.includes(key)).flatMap(({ key }) => present(key)))

  return {
    /** @param {State} state */
    update({ machine }) {
      values = machine.values
      preset.value = String(machine.preset)
      preset.title = form.presets[machine.preset].name
      find(root, '.source').textContent = form.presets[machine.preset].source
      const original = form.presets[machine.preset].values
      save.disabled = machine.faults.length > 0
      reset.disabled = same(values, original)
      for (const { parameter, element, show } of fields) {
        const fault = machine.faults.find(({ key }) => key === parameter.key)?.message ?? ''
        show(values[parameter.key] ?? null, fault)
        element.classList.toggle('changed', !same(values[parameter.key], original[parameter.key]))
        if (fault && more.contains(element)) more.open = true
      }
      const elsewhere = machine.faults
        .filter(({ key }) => key === null || !byKey.has(key))
        .map(({ message }) => message)
      find(root, '.faults').textContent = elsewhere.join(' ')
    },
  }
}

/** One field of the form. @param {Parameter} parameter @param {(key: string, value: Value) => void} changed */
function field(parameter, changed) {
  const { key, label, doc, kind, unit, min, max, words } = parameter
  const id = `field-${key.replaceAll('.', '-')}`
  const control =
    kind === 'choice'
      ? make('select', { id }, ...words.map((word) => make('option', { value: word }, word)))
      : make('input', { id })
  if (control instanceof HTMLInputElement) {
    control.type = kind === 'flag' ? 'checkbox' : 'text'
    if (kind === 'number') control.inputMode = 'decimal'
  }
  const bounds = min !== null && max !== null ? `${shown(min)} to ${shown(max)}${unit ? ` ${unit}` : ''}` : ''
  control.title = bounds
  control.setAttribute('aria-describedby', `${id}-doc ${id}-fault`)
  const fault = make('p', { className: 'fault', id: `${id}-fault` })
  const element = make(
    'div',
    { className: `field ${kind}` },
    make('label', { htmlFor: id, title: doc }, label),
    make('span', { className: 'value' }, control, make('span', { className: 'unit' }, unit ?? '')),
    make('p', { className: 'doc', id: `${id}-doc` }, doc),
    fault,
  )
  const event = kind === 'choice' || kind === 'flag' ? 'change' : 'input'
  control.addEventListener(event, () => changed(key, typed(kind, control)))

  return {
    parameter,
    element,
    /** Shows a value, unless it is what the user is typing. @param {Value} value @param {string} message */
    show(value, message) {
      fault.textContent = message
      control.toggleAttribute('aria-invalid', message !== '')
      if (same(typed(kind, control), value)) return
      if (kind === 'flag') /** @type {HTMLInputElement} */ (control).checked = value === true
      else control.value = text(value)
    },
  }
}

/** The value in a control; null where it is empty. @param {Parameter["kind"]} kind @param {HTMLInputElement | HTMLSelectElement} control @returns {Value} */
function typed(kind, control) {
  const written = control.value.trim()
  if (kind === 'flag') return /** @type {HTMLInputElement} */ (control).checked
  if (kind === 'text' || kind === 'choice') return written
  if (written === '') return null
  if (kind === 'number') return numberOr(written)
  if (kind === 'list') return /** @type {number[]} */ (written.split(/[;\s]+|,\s+/).map(numberOr))
  if (kind === 'codes' || kind === 'tools') {
    const pairs = written.split(/[;,]/).map((pair) => pair.split('=').map((part) => part.trim()))
    return /** @type {Record<string, number>} */ (
      Object.fromEntries(pairs.filter(([code]) => code).map(([code, time]) => [code, numberOr(time ?? '')]))
    )
  }
  return written
}

/** A number where the text is one; Rust complains about any other text. @param {string} written */
function numberOr(written) {
  const number = Number(written.replace(',', '.'))
  return written !== '' && Number.isFinite(number) ? number : written
}

/** @param {Value} value */
function text(value) {
  if (value === null) return ''
  if (Array.isArray(value)) return value.join('; ')
  if (typeof value === 'object')
    return Object.entries(value)
      .map(([code, time]) => `${code} = ${time}`)
      .join('; ')
  return typeof value === 'number' ? shown(value) : String(value)
}

/** @param {number} value */
function shown(value) {
  return String(Number(value.toPrecision(12)))
}

/** @param {unknown} a @param {unknown} b */
function same(a, b) {
  const settled = (/** @type {unknown} */ value) =>
    value && typeof value === 'object' && !Array.isArray(value)
      ? Object.entries(value).sort(([x], [y]) => (x < y ? -1 : 1))
      : value
  return JSON.stringify(settled(a)) === JSON.stringify(settled(b))
}
