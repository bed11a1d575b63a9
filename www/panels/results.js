// The table of cycle times, one row a tolerance.

import { price } from '../pkg/truefeed.js'
import { columnLabel, columnsOf, isStill } from '../columns.js'
import { find, make, scroll } from '../dom.js'
import { clock, count, difference, millimetres, money, percent, seconds } from '../format.js'
import { deviationLabel, toleranceLabel } from '../labels.js'
import { say } from '../texts.js'

/** @import { Column, Form, Held, Outcome, Place, RunSummary, State, Value } from "../types.js" */

/** @type {[Exclude<keyof import("../types.js").Breakdown, "other">, string][]} */
const PARTS = [
  ['cutting_s', say.common.cutting],
  ['rapid_s', say.common.rapid],
  ['dwell_s', say.common.dwell],
  ['tool_change_s', say.common.toolChange],
  ['other_s', say.common.other],
]

/** More parts of a program are only counted. */
const MOST_HELD = 24

/** What makes no place exceed its tolerance. */
const CURE = { key: 'interpolator.corner_mode', word: 'guaranteed' }

/**
 * @param {HTMLElement} root
 * @param {Form} form
 * @param {{show(place: Pick<Place, 'distance_mm'>): void, setParameter(key: string, value: Value): void}} actions
 */
export function mount(root, form, actions) {
  const place = find(root, '.table')
  const mode = form.fields.find(({ key }) => key === CURE.key)?.label ?? ''
  /** Where the contour error is above the tolerance, and what helps. @param {Outcome} outcome @param {State} state */
  function beyond(outcome, state) {
    const { machine } = state
    const items = columnsOf(state, outcome).flatMap((column, index) => {
      const places = outcome.runs.get(column)?.summary.beyond_tolerance ?? []
      return places.length > 0 ? [item(column, index, places)] : []
    })
    if (items.length === 0) return []
    if (machine.values[CURE.key] !== CURE.word) {
      const cure = make('button', { type: 'button', className: 'cure' }, say.results.setTo(mode.toLowerCase(), CURE.word))
      cure.title = say.results.holdsEverywhere
      cure.addEventListener('click', () => actions.setParameter(CURE.key, CURE.word))
      items.push(make('li', {}, say.results.toHold, cure))
    }
    return [make('ul', { className: 'beyond' }, ...items)]
  }

  /** One column with the way to its worst place. @param {Column} column @param {number} index @param {Place[]} places */
  function item(column, index, places) {
    const worst = places.reduce((a, b) => (b.max_contour_error_mm > a.max_contour_error_mm ? b : a))
    const lines = linesOf(worst)
    const go = make('button', { type: 'button', title: say.common.showInChart })
    go.append(say.results.worstAt(deviationLabel(worst.max_contour_error_mm), lines))
    go.addEventListener('click', () => actions.show(worst))
    const number = say.results.exceeded(places.length, count(places.length))
    const swatch = make('span', { className: `swatch curve-${index}` })
    return make('li', {}, swatch, make('b', {}, columnLabel(column)), ' ', number, go)
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
    const title = make('b', {}, say.common.asProgrammed)
    return [make('div', { className: 'held' }, title, make('ol', {}, ...items))]
  }

  return {
    /** @param {State} state */
    update(state) {
      const program = state.programs.find(({ id }) => id === state.selected)
      const outcome = program?.outcome
      const stale = Boolean(outcome) && outcome?.motion !== state.machine.motion
      root.classList.toggle('stale', stale)
      if (program && isStill(outcome)) {
        const sentence = program.file.size === 0 ? say.results.empty(program.name) : say.results.nothingMoves(program.name)
        place.replaceChildren(make('p', { className: 'sentence' }, sentence))
      } else if (program && outcome) {
        place.replaceChildren(
          table(outcome, columnsOf(state, outcome), JSON.stringify(state.machine.values)),
          ...inDoubt(columnsOf(state, outcome), outcome),
          ...programmed(outcome),
          ...beyond(outcome, state),
          about(outcome, stale ? outOfDate(state) : '', Number(state.machine.values['rates.hourly']) > 0),
        )
      } else {
        place.replaceChildren(make('p', { className: 'empty' }, state.progress ? say.common.computing : say.common.notComputed))
      }
    },
  }
}

/** By how much a cycle time may be off; why stands below the table. @param {RunSummary} run */
function unsure({ trust, in_doubt: why }) {
  if (!why) return []
  const bound = trust.seconds_in_doubt > 0 ? seconds(trust.seconds_in_doubt) : '?'
  return [' ', make('span', { className: 'unsure', title: why }, say.results.unsure(bound, trust.bounded))]
}

/** What of a cycle time is in doubt and why, each sentence once. @param {Column[]} columns @param {Outcome} outcome */
function inDoubt(columns, outcome) {
  const sentences = new Set(columns.flatMap((column) => outcome.runs.get(column)?.summary.in_doubt ?? []))
  return [...sentences].map((sentence) => make('p', { className: 'doubt' }, sentence))
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

/** @param {Outcome} outcome @param {Column[]} columns @param {string} machine  JSON */
function table(outcome, columns, machine) {
  // Rates change no motion: the price is told by the form as it is now, where that has no fault.
  const priceOf = (/** @type {RunSummary} */ run) => price(machine, run.cycle_time_s) ?? run.price
  const priced = [...outcome.runs.values()].some(({ summary }) => priceOf(summary))
  const title = (/** @type {string} */ text, colSpan = 1, className = '') => make('th', { scope: 'col', colSpan, className }, text)
  const titles = [title(say.common.tolerance), title(say.common.cycleTime, 2)]
  if (priced) titles.push(title(say.results.price))
  titles.push(title(say.common.programmed), title(say.common.difference, 2))
  for (const [, part] of PARTS) titles.push(title(part, 1, 'part'))
  titles.push(title(say.common.contourError))
  const head = make('tr', {}, ...titles)
  const programmed = outcome.summary.programmed_time_s
  const rows = columns.map((column, index) => {
    const label = make(
      'th',
      { scope: 'row' },
      make('span', { className: `swatch curve-${index}` }),
      columnLabel(column),
    )
    const run = outcome.runs.get(column)?.summary
    if (!run) return make('tr', { className: 'waiting' }, label, make('td', { colSpan: titles.length + 1 }, '…'))
    const longer = run.cycle_time_s - programmed
    const cells = [
      make('data', { value: String(run.cycle_time_s) }, clock(run.cycle_time_s)),
      make('span', {}, seconds(run.cycle_time_s), ...unsure(run)),
      ...(priced ? [make('b', { className: 'price' }, money(priceOf(run)))] : []),
      seconds(programmed),
      difference(longer),
      percent(longer / programmed),
    ].map((cell) => make('td', {}, cell))
    for (const [key] of PARTS) cells.push(make('td', { className: 'part' }, seconds(run.breakdown[key])))
    cells.push(make('td', {}, deviationLabel(run.max_contour_error_mm)))
    return make('tr', { className: column === null ? 'programmed' : '' }, label, ...cells)
  })
  const table = make('table', {}, make('thead', {}, head), make('tbody', {}, ...rows))
  return scroll(table)
}

/** Why the results in sight are not those of the machine in the form. @param {State} state */
export function outOfDate({ machine, paused }) {
  if (machine.faults.length > 0) return say.results.ofBeforeFault
  return paused ? say.results.ofBefore : say.results.anew
}

/** @param {Outcome} outcome @param {string} note @param {boolean} hasPrice */
function about({ steps, summary }, note, hasPrice) {
  const errors = summary.diagnostics.filter(({ severity }) => severity === 'error').length
  const facts = say.results.about(count(steps.end.length), millimetres(steps.end.at(-1) ?? 0))
  const rate = make('a', { href: '#field-rates-hourly' }, say.results.giveRate)
  const unpriced = hasPrice ? [] : [' ', rate, say.results.toSeePrices, make('a', { href: '#quote' }, say.results.quote), '.']
  const link = make(
    'a',
    { href: '#diagnostics', className: 'errors' },
    say.results.notRun(errors, count(errors)),
  )
  return make('p', { className: 'about' }, ...(errors > 0 ? [link, ' '] : []), facts + note, ...unpriced)
}
