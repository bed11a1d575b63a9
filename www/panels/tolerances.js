// The contour tolerances as rows, the program's own first: one is quoted, the others are compared. Added by typing, removed by
// × or Delete. Text becomes a tolerance in Rust.

import { toleranceFromText, toleranceLabel as labelToRead } from '../pkg/truefeed.js'
import { columnKey, columnLabel, columnsOf, programInSight, quotedColumn } from '../columns.js'
import { find, make } from '../dom.js'
import { count, duration, fineSymbol, seconds } from '../format.js'
import { deviationLabel, toleranceKey, toleranceLabel } from '../labels.js'
import { say } from '../texts.js'

/** @import { Column, Form, Held, Outcome, Place, State, Value } from "../types.js" */

/** More parts of a program are only counted. */
const MOST_HELD = 24

/** What makes no place exceed its tolerance. */
const CURE = { key: 'interpolator.corner_mode', word: 'guaranteed' }

/**
 * @param {HTMLElement} root
 * @param {{most: number, usual: number[]}} limits
 * @param {{setTolerances(tolerances: number[]): void, setProgrammed(shown: boolean): void, setQuoted(column: Column): void, show(place: Pick<Place, 'distance_mm'>): void, setParameter(key: string, value: Value): void}} actions
 */
export function mount(root, { most, usual }, actions) {
  const place = find(root, '.table')
  const form = /** @type {HTMLFormElement} */ (find(root, 'form'))
  const input = /** @type {HTMLInputElement} */ (find(form, 'input'))
  const fault = find(root, '.fault')
  const reset = find(root, '.reset')
  const own = find(root, '.own')
  const holds = find(root, '.holds')
  /** @type {number[]} */
  let tolerances = []
  /** @type {Column[]} */
  let columns = []
  /** The unit that the input names, which is the one that it is read in. */
  let unit = ''
  /** What the rows show now. @type {unknown[]} */
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
    root.querySelector('input')?.focus()
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

  /** Names another unit in the input; what was typed before was meant in the old one, so that it goes. @param {string} chosen */
  function name(chosen) {
    unit = chosen
    input.placeholder = say.tolerances.addIn(fineSymbol())
    input.ariaLabel = say.tolerances.addTolerance(fineSymbol())
    input.value = ''
    tell('')
  }

  /** Adds what was typed; returns why not. @param {string} text */
  function add(text) {
    let tolerance
    try {
      tolerance = toleranceFromText(text, unit)
    } catch (reason) {
      return String(reason)
    }
    // Two that differ but look alike in the unit shown could not be told apart.
    if (tolerances.some((other) => [toleranceKey, toleranceLabel].some((label) => label(other) === label(tolerance)))) return say.tolerances.isThere(toleranceLabel(tolerance))
    if (columns.length >= most) return say.tolerances.atMost(most)
    actions.setTolerances([...tolerances, tolerance])
    return ''
  }

  /** @param {Column} column */
  function remove(column) {
    if (column !== null && tolerances.length === 1) return tell(say.tolerances.oneStays)
    tell('')
    const index = columns.indexOf(column)
    if (column === null) actions.setProgrammed(false)
    else actions.setTolerances(tolerances.filter((other) => other !== column))
    const buttons = /** @type {NodeListOf<HTMLElement>} */ (root.querySelectorAll('.chip .remove'))
    buttons[Math.min(index, buttons.length - 1)]?.focus()
  }

  /** @param {Column} column @param {number} index @param {Outcome | null | undefined} outcome @param {boolean} isQuoted */
  function row(column, index, outcome, isQuoted) {
    const label = columnLabel(column)
    const run = outcome?.runs.get(column)?.summary
    const choice = make('input', { type: 'radio', name: 'quoted', value: columnKey(column), checked: isQuoted })
    choice.addEventListener('change', () => actions.setQuoted(column))
    const removal = make('button', { type: 'button', className: 'remove', title: say.tolerances.removeByDelete }, '×')
    removal.setAttribute('aria-label', say.tolerances.remove(label))
    removal.addEventListener('click', () => remove(column))
    const swatch = make('span', { className: `swatch curve-${index}` })
    const name = make('label', {}, choice, make('span', {}, swatch, make('span', { className: 'label' }, label)))
    const time = run ? make('data', { value: String(run.cycle_time_s), title: seconds(run.cycle_time_s) }, duration(run.cycle_time_s)) : '…'
    const item = make(
      'tr',
      { className: column === null ? 'chip programmed' : 'chip' },
      make('th', { scope: 'row' }, name),
      make('td', {}, time),
      make('td', { className: 'deviation' }, run ? deviationLabel(run.max_contour_error_mm) : ''),
      make('td', {}, removal),
    )
    item.addEventListener('keydown', ({ key }) => {
      if (key === 'Delete' || key === 'Backspace') remove(column)
    })
    return item
  }

  /** How far the motion leaves its tolerance, as figures, and what holds it. @param {Outcome} outcome @param {State} state */
  function beyond(outcome, state) {
    const items = columns.flatMap((column) => {
      const places = outcome.runs.get(column)?.summary.beyond_tolerance ?? []
      return places.length > 0 ? [item(column, places)] : []
    })
    if (items.length === 0) return []
    const list = make('ul', { className: 'beyond' }, ...items)
    if (state.machine.values[CURE.key] === CURE.word) return [list]
    const cure = make('button', { type: 'button', className: 'cure' }, say.results.hold)
    cure.title = say.results.holdsEverywhere
    cure.addEventListener('click', () => actions.setParameter(CURE.key, CURE.word))
    return [list, make('p', {}, cure)]
  }

  /** One tolerance with the way to its worst place. @param {Column} column @param {Place[]} places */
  function item(column, places) {
    const worst = places.reduce((a, b) => (b.max_contour_error_mm > a.max_contour_error_mm ? b : a))
    const go = make('button', { type: 'button', className: 'plain', title: say.common.showInChart })
    go.append(say.results.worstAt(deviationLabel(worst.max_contour_error_mm), linesOf(worst)))
    go.addEventListener('click', () => actions.show(worst))
    return make('li', {}, say.results.exceeded(columnLabel(column), places.length, count(places.length)), go)
  }

  return {
    /** Adds a tolerance (mm) that was pointed at, or says why not. @param {number} tolerance */
    choose(tolerance) {
      tell(add(labelToRead(tolerance)))
    },
    /** @param {State} state */
    update(state) {
      if (unit !== state.lengthUnit) name(state.lengthUnit)
      const program = programInSight(state)
      const outcome = program?.outcome
      const sets = Boolean(outcome && outcome.held.length > 0)
      columns = columnsOf(state, program)
      tolerances = state.tolerances
      own.hidden = !sets || state.programmed
      reset.hidden = usual.length === tolerances.length && usual.every((value, i) => value === tolerances[i])
      const quoted = quotedColumn(state, program)
      const now = [state.lengthUnit, outcome, quoted, state.machine.values[CURE.key], ...columns, ...columns.map((column) => outcome?.runs.get(column))]
      if (now.length === shown.length && now.every((value, i) => value === shown[i])) return
      shown = now
      // Times arrive while a key is on its way to a tolerance.
      const focused = place.contains(document.activeElement) ? document.activeElement : null
      const key = focused?.closest('tr')?.querySelector('input')?.value
      const titles = [say.tolerances.quoted, say.common.cycleTime, say.tolerances.leaves].map((title) => make('th', { scope: 'col' }, title))
      const rows = columns.map((column, index) => row(column, index, outcome, column === quoted))
      place.replaceChildren(make('table', {}, make('thead', {}, make('tr', {}, ...titles, make('td', {}))), make('tbody', {}, ...rows)))
      const inputs = /** @type {NodeListOf<HTMLInputElement>} */ (place.querySelectorAll('.chip input'))
      const again = [...inputs].find((input) => input.value === key)
      if (focused?.matches('.remove')) /** @type {HTMLElement | null | undefined} */ (again?.closest('tr')?.querySelector('.remove'))?.focus()
      else again?.focus()
      holds.replaceChildren(...(outcome ? [...programmed(outcome), ...beyond(outcome, state)] : []))
    },
  }

  /** Where each of the program's own tolerances holds. @param {Outcome} outcome */
  function programmed({ held }) {
    if (held.length === 0) return []
    const items = held.slice(0, MOST_HELD).map((part) => {
      const go = make('button', { type: 'button', title: say.common.showInChart }, linesOf(part))
      go.addEventListener('click', () => actions.show(part))
      const source = part.source === '' ? [] : [' ', make('code', {}, part.source)]
      return make('li', {}, go, ` ${wordsOf(part)}`, ...source)
    })
    if (held.length > MOST_HELD) items.push(make('li', {}, say.results.andMore(count(held.length - MOST_HELD))))
    return [make('div', { className: 'held' }, make('b', {}, say.common.asProgrammed), make('ol', {}, ...items))]
  }
}

/** The lines of a place in words. @param {{lines: [number, number]}} place */
function linesOf({ lines: [first, last] }) {
  return first === last ? say.results.line(first) : say.results.lines(first, last)
}

/** What the program asks for in words. @param {Held} part */
function wordsOf({ mode, tolerance_mm: tolerance }) {
  if (mode === 'exact_stop') return say.results.exactStops
  const label = toleranceLabel(tolerance)
  if (mode === 'machine') return say.results.ofMachine(label)
  return mode === 'distance' ? say.results.atMost(label) : label
}
