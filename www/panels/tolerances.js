// The contour tolerances as chips, the program's own first: add by typing, remove by × or Delete. Text becomes a
// tolerance in Rust.

import { toleranceFromText } from '../pkg/truefeed.js'
import { columnLabel, columnsOf } from '../columns.js'
import { find, make } from '../dom.js'
import { toleranceLabel } from '../labels.js'
import { say } from '../texts.js'

/** @import { Column, State } from "../types.js" */

/**
 * @param {HTMLElement} root
 * @param {{most: number, usual: number[]}} limits
 * @param {{setTolerances(tolerances: number[]): void, setProgrammed(shown: boolean): void}} actions
 */
export function mount(root, { most, usual }, actions) {
  const chips = find(root, '.chips')
  const form = /** @type {HTMLFormElement} */ (find(root, 'form'))
  const input = /** @type {HTMLInputElement} */ (find(root, 'input'))
  const fault = find(root, '.fault')
  const reset = find(root, '.reset')
  const own = find(root, '.own')
  /** @type {number[]} */
  let tolerances = []
  /** What the chips show now. @type {Column[]} */
  let shown = []

  form.addEventListener('submit', (event) => {
    event.preventDefault()
    const message = add(input.value)
    tell(message)
    if (!message) input.value = ''
  })
  input.addEventListener('input', () => tell(''))
  own.addEventListener('click', () => {
    tell('')
    actions.setProgrammed(true)
    chips.querySelector('button')?.focus()
  })
  reset.addEventListener('click', () => {
    tell('')
    actions.setTolerances(usual)
  })

  /** @param {string} message */
  function tell(message) {
    fault.textContent = message
    input.ariaInvalid = message ? 'true' : null
  }

  /** Adds what was typed; returns why not. @param {string} text */
  function add(text) {
    let tolerance
    try {
      tolerance = toleranceFromText(text)
    } catch (reason) {
      return String(reason)
    }
    const label = toleranceLabel(tolerance)
    if (tolerances.some((other) => toleranceLabel(other) === label)) return say.tolerances.isThere(label)
    if (shown.length >= most) return say.tolerances.atMost(most)
    actions.setTolerances([...tolerances, tolerance])
    return ''
  }

  /** @param {Column} column */
  function remove(column) {
    if (column !== null && tolerances.length === 1) return tell(say.tolerances.oneStays)
    tell('')
    const index = shown.indexOf(column)
    if (column === null) actions.setProgrammed(false)
    else actions.setTolerances(tolerances.filter((other) => other !== column))
    const buttons = chips.querySelectorAll('button')
    buttons[Math.min(index, buttons.length - 1)]?.focus()
  }

  return {
    /** Adds a tolerance (mm) that was pointed at, or says why not. @param {number} tolerance */
    choose(tolerance) {
      tell(add(toleranceLabel(tolerance)))
    },
    /** @param {State} state */
    update(state) {
      const outcome = state.programs.find(({ id }) => id === state.selected)?.outcome
      const sets = outcome !== null && outcome !== undefined && outcome.held.length > 0
      const columns = columnsOf(state, outcome)
      own.hidden = !sets || state.programmed
      reset.hidden =
        usual.length === state.tolerances.length && usual.every((value, i) => value === state.tolerances[i])
      tolerances = state.tolerances
      if (columns.length === shown.length && columns.every((value, i) => value === shown[i])) return
      shown = columns
      chips.replaceChildren(...columns.map(chip))
    },
  }

  /** @param {Column} column @param {number} index */
  function chip(column, index) {
    const label = columnLabel(column)
    const button = make('button', { type: 'button', title: say.tolerances.removeByDelete }, '×')
    button.setAttribute('aria-label', say.tolerances.remove(label))
    const swatch = make('span', { className: `swatch curve-${index}` })
    const item = make('li', { className: 'chip' }, swatch, label, button)
    button.addEventListener('click', () => remove(column))
    item.addEventListener('keydown', ({ key }) => {
      if (key === 'Delete' || key === 'Backspace') remove(column)
    })
    return item
  }
}
