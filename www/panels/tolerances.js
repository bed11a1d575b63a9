// The contour tolerances as chips: add by typing, remove by × or Delete. Text becomes a tolerance in Rust.

import { toleranceFromText, toleranceLabel } from '../pkg/truefeed.js'
import { find, make } from '../dom.js'

/** @import { State } from "../types.js" */

/**
 * @param {HTMLElement} root
 * @param {{most: number, usual: number[]}} limits
 * @param {{setTolerances(tolerances: number[]): void}} actions
 */
export function mount(root, { most, usual }, actions) {
  const chips = find(root, '.chips')
  const form = /** @type {HTMLFormElement} */ (find(root, 'form'))
  const input = /** @type {HTMLInputElement} */ (find(root, 'input'))
  const fault = find(root, '.fault')
  const reset = find(root, '.reset')
  /** @type {number[]} */
  let tolerances = []

  form.addEventListener('submit', (event) => {
    event.preventDefault()
    const message = add(input.value)
    say(message)
    if (!message) input.value = ''
  })
  input.addEventListener('input', () => say(''))
  reset.addEventListener('click', () => {
    say('')
    actions.setTolerances(usual)
  })

  /** @param {string} message */
  function say(message) {
    fault.textContent = message
    input.toggleAttribute('aria-invalid', message !== '')
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
    if (tolerances.some((other) => toleranceLabel(other) === label)) return `${label} is there already.`
    if (tolerances.length >= most) return `At most ${most} tolerances fit one chart. Remove one first.`
    actions.setTolerances([...tolerances, tolerance])
    return ''
  }

  /** @param {number} tolerance */
  function remove(tolerance) {
    if (tolerances.length === 1) return say('One tolerance has to stay. Add another one first.')
    say('')
    const index = tolerances.indexOf(tolerance)
    actions.setTolerances(tolerances.filter((other) => other !== tolerance))
    const buttons = chips.querySelectorAll('button')
    buttons[Math.min(index, buttons.length - 1)]?.focus()
  }

  return {
    /** @param {State} state */
    update(state) {
      const same =
        tolerances.length === state.tolerances.length && tolerances.every((value, i) => value === state.tolerances[i])
      reset.hidden =
        usual.length === state.tolerances.length && usual.every((value, i) => value === state.tolerances[i])
      if (same) return
      tolerances = state.tolerances
      chips.replaceChildren(
        ...tolerances.map((tolerance, index) => {
          const label = toleranceLabel(tolerance)
          const button = make('button', { type: 'button', title: 'Remove (Delete)' }, '×')
          button.setAttribute('aria-label', `Remove ${label}`)
          const swatch = make('span', { className: `swatch curve-${index}` })
          const chip = make('li', { className: 'chip' }, swatch, label, button)
          button.addEventListener('click', () => remove(tolerance))
          chip.addEventListener('keydown', ({ key }) => {
            if (key === 'Delete' || key === 'Backspace') remove(tolerance)
          })
          return chip
        }),
      )
    },
  }
}
