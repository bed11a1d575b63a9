// One field of a form that Rust describes. It keeps texts and passes values on; what they mean and whether they are
// allowed is for Rust to say.

import { make } from './dom.js'
import { parsed, typed as shown, worded } from './format.js'
import { say } from './texts.js'

/** @import { Parameter, Value } from "./types.js" */

/**
 * @typedef {object} Entry
 * @property {Parameter} parameter
 * @property {HTMLElement} element
 * @property {(value: Value, message: string) => void} show  shows a value, unless it is what the user is typing
 */

/** The id of a field's control. @param {string} prefix @param {string} key */
export const idOf = (prefix, key) => `${prefix}-${key.replaceAll('.', '-')}`

/**
 * @param {string} prefix  of its id
 * @param {Parameter} parameter
 * @param {(key: string, value: Value) => void} changed
 * @returns {Entry}
 */
export function field(prefix, parameter, changed) {
  const { key, label, doc, kind, unit, min, max, words, neutral } = parameter
  const id = idOf(prefix, key)
  const control =
    kind === 'choice' ? make('select', { id }, ...words.map((word) => make('option', { value: word }, titleOf(word)))) : kind === 'lines' ? make('textarea', { id, rows: 3 }) : make('input', { id })
  if (control instanceof HTMLInputElement) {
    control.type = kind === 'flag' ? 'checkbox' : 'text'
    if (kind === 'number') control.inputMode = 'decimal'
  }
  const ofUnit = unit ? ` ${unit}` : ''
  const bounds = min !== null && max !== null ? say.field.range(shown(min), shown(max), ofUnit) : ''
  control.title = bounds
  control.setAttribute('aria-describedby', `${id}-doc ${id}-fault`)
  const fault = make('p', { className: 'fault', id: `${id}-fault` })
  const written = kind === 'flag' ? (neutral ? say.field.on : say.field.off) : worded(text(neutral)) || say.field.empty
  const toNeutral = make('button', { type: 'button', className: 'neutral', title: say.field.backTo(written) }, say.common.reset)
  toNeutral.setAttribute('aria-label', say.field.resetTo(label, written))
  const hint = make('p', { className: 'hint' }, say.field.neutral(typeof neutral === 'number' ? written + ofUnit : written, bounds), toNeutral)
  const element = make(
    'div',
    { className: `field ${kind}` },
    make('label', { htmlFor: id, title: worded(doc) }, label),
    make('span', { className: 'value' }, control, make('span', { className: 'unit' }, unit ?? '')),
    make('p', { className: 'doc', id: `${id}-doc` }, worded(doc)),
    hint,
    fault,
  )
  const event = kind === 'choice' || kind === 'flag' ? 'change' : 'input'
  control.addEventListener(event, () => changed(key, typed(kind, control)))
  toNeutral.addEventListener('click', () => {
    changed(key, neutral)
    control.focus()
  })

  return {
    parameter,
    element,
    show(value, message) {
      fault.textContent = message
      control.ariaInvalid = message ? 'true' : null
      element.classList.toggle('set', !same(value, neutral))
      if (same(typed(kind, control), value)) return
      if (kind === 'flag') /** @type {HTMLInputElement} */ (control).checked = value === true
      else control.value = text(value)
    },
  }
}

/** Choices whose word says little. @type {Record<string, string>} */
const CHOICES = { paper: say.choices.paper, guaranteed: say.choices.guaranteed }

/** What a choice is called. @param {string} word */
const titleOf = (word) => CHOICES[word] ?? worded(word)

/** The value in a control; null where it is empty. @param {Parameter["kind"]} kind @param {HTMLInputElement | HTMLSelectElement | HTMLTextAreaElement} control @returns {Value} */
function typed(kind, control) {
  const written = control.value.trim()
  if (kind === 'flag') return /** @type {HTMLInputElement} */ (control).checked
  if (kind === 'text' || kind === 'lines' || kind === 'choice') return written
  if (written === '') return null
  if (kind === 'number') return numberOr(written)
  if (kind === 'list')
    return /** @type {number[]} */ (
      written
        .split(/[;\s]+|,\s+/)
        .filter(Boolean)
        .map(numberOr)
    )
  if (kind === 'codes' || kind === 'tools') {
    // A comma parts entries only where another one follows it; else it is a decimal comma.
    const pairs = written.split(/;|,(?=[^;,=]*=)/).map((pair) => pair.split('=').map((part) => part.trim()))
    return /** @type {Record<string, number>} */ (Object.fromEntries(pairs.filter(([code]) => code).map(([code, time]) => [code, numberOr(time ?? '')])))
  }
  return written
}

/** A number where the text is one; Rust complains about any other text. @param {string} written */
function numberOr(written) {
  const number = parsed(written)
  return Number.isFinite(number) ? number : written
}

/** @param {Value} value */
function text(value) {
  if (value === null) return ''
  if (Array.isArray(value)) return value.map(entry).join('; ')
  if (typeof value === 'object')
    return Object.entries(value)
      .map(([code, time]) => `${code} = ${entry(time)}`)
      .join('; ')
  return typeof value === 'number' ? shown(value) : String(value)
}

/** One of several; what is no number yet stays as it was typed. @param {unknown} value */
const entry = (value) => (typeof value === 'number' ? shown(value) : String(value))

/** Whether two values are the same, an empty field and none among them. @param {unknown} a @param {unknown} b */
export function same(a, b) {
  const settled = (/** @type {unknown} */ value) => (value && typeof value === 'object' && !Array.isArray(value) ? Object.entries(value).sort(([x], [y]) => (x < y ? -1 : 1)) : (value ?? null))
  return JSON.stringify(settled(a)) === JSON.stringify(settled(b))
}
