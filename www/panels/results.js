// The table of cycle times, one row a tolerance.

import { deviationLabel, price, toleranceLabel } from '../pkg/truefeed.js'
import { columnLabel, columnsOf } from '../columns.js'
import { find, make, scroll } from '../dom.js'
import { clock, count, difference, millimetres, money, percent, seconds } from '../format.js'

/** @import { Column, Form, Held, Outcome, Place, RunSummary, State, Value } from "../types.js" */

/** @type {[Exclude<keyof import("../types.js").Breakdown, "other">, string][]} */
const PARTS = [
  ['cutting_s', 'Cutting'],
  ['rapid_s', 'Rapid'],
  ['dwell_s', 'Dwell'],
  ['tool_change_s', 'Tool change'],
  ['other_s', 'Other'],
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
      const cure = make('button', { type: 'button', className: 'cure' }, `Set ${mode.toLowerCase()} to ${CURE.word}`)
      cure.title = 'The motion holds the tolerance everywhere'
      cure.addEventListener('click', () => actions.setParameter(CURE.key, CURE.word))
      items.push(make('li', {}, 'To hold it everywhere: ', cure))
    }
    return [make('ul', { className: 'beyond' }, ...items)]
  }

  /** One column with the way to its worst place. @param {Column} column @param {number} index @param {Place[]} places */
  function item(column, index, places) {
    const worst = places.reduce((a, b) => (b.max_contour_error_mm > a.max_contour_error_mm ? b : a))
    const lines = linesOf(worst)
    const go = make('button', { type: 'button', title: 'Show it in the chart' })
    go.append(`${deviationLabel(worst.max_contour_error_mm)} at ${lines}`)
    go.addEventListener('click', () => actions.show(worst))
    const number = `exceeded in ${count(places.length)} ${places.length === 1 ? 'place' : 'places'}, up to `
    const swatch = make('span', { className: `swatch curve-${index}` })
    return make('li', {}, swatch, make('b', {}, columnLabel(column)), ` ${number}`, go)
  }

  /** Where each of the program's own tolerances holds. @param {Outcome} outcome */
  function programmed({ held }) {
    if (held.length === 0) return []
    const items = held.slice(0, MOST_HELD).map((part) => {
      const go = make('button', { type: 'button', title: 'Show it in the chart' }, linesOf(part))
      go.addEventListener('click', () => actions.show(part))
      const source = part.source === '' ? [] : [' ', make('code', {}, part.source)]
      return make('li', {}, go, ` ${wordsOf(part)}`, ...source)
    })
    if (held.length > MOST_HELD) items.push(make('li', {}, `and ${count(held.length - MOST_HELD)} more`))
    const title = make('b', {}, 'As programmed')
    return [make('div', { className: 'held' }, title, make('ol', {}, ...items))]
  }

  return {
    /** @param {State} state */
    update(state) {
      const program = state.programs.find(({ id }) => id === state.selected)
      const outcome = program?.outcome
      const stale = Boolean(outcome) && outcome?.motion !== state.machine.motion
      root.classList.toggle('stale', stale)
      if (program && outcome) {
        place.replaceChildren(
          table(outcome, columnsOf(state, outcome), JSON.stringify(state.machine.values)),
          ...programmed(outcome),
          ...beyond(outcome, state),
          about(outcome, stale ? outOfDate(state) : '', Number(state.machine.values['rates.hourly']) > 0),
        )
      } else {
        place.replaceChildren(make('p', { className: 'empty' }, state.progress ? 'Computing …' : 'Not computed yet.'))
      }
    },
  }
}

/** The lines of a place in words. @param {{lines: [number, number]}} place */
function linesOf({ lines: [first, last] }) {
  return first === last ? `line ${first}` : `lines ${first}–${last}`
}

/** What the program asks for in words. @param {Held} part */
function wordsOf({ mode, tolerance_mm: tolerance }) {
  if (mode === 'exact_stop') return 'exact stops'
  const label = toleranceLabel(tolerance)
  if (mode === 'machine') return `${label}, the machine’s`
  return mode === 'distance' ? `at most ${label}` : label
}

/** @param {Outcome} outcome @param {Column[]} columns @param {string} machine  JSON */
function table(outcome, columns, machine) {
  // Rates change no motion: the price is told by the form as it is now, where that has no fault.
  const priceOf = (/** @type {RunSummary} */ run) => price(machine, run.cycle_time_s) ?? run.price
  const priced = [...outcome.runs.values()].some(({ summary }) => priceOf(summary))
  /** @type {[string, number][]} */
  const titles = [['Tolerance', 1], ['Cycle time', 2], ...priceTitles(priced), ['Programmed', 1], ['Difference', 2]]
  for (const [, title] of PARTS) titles.push([title, 1])
  titles.push(['Contour error', 1])
  const head = make('tr', {}, ...titles.map(([title, colSpan]) => make('th', { scope: 'col', colSpan }, title)))
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
      seconds(run.cycle_time_s),
      ...(priced ? [make('b', { className: 'price' }, money(priceOf(run)))] : []),
      seconds(programmed),
      difference(longer),
      percent(longer / programmed),
      ...PARTS.map(([key]) => seconds(run.breakdown[key])),
      deviationLabel(run.max_contour_error_mm),
    ]
    return make('tr', { className: column === null ? 'programmed' : '' }, label, ...cells.map((cell) => make('td', {}, cell)))
  })
  const table = make('table', {}, make('thead', {}, head), make('tbody', {}, ...rows))
  return scroll(table)
}

/** @param {boolean} priced @returns {[string, number][]} */
const priceTitles = (priced) => (priced ? [['Price', 1]] : [])

/** Why the results in sight are not those of the machine in the form. @param {State} state */
function outOfDate({ machine, paused }) {
  if (machine.faults.length > 0) return ' These are the results of the machine before: the form has a fault.'
  return paused ? ' These are the results of the machine before.' : ' Computing anew for the changed machine …'
}

/** @param {Outcome} outcome @param {string} note @param {boolean} hasPrice */
function about({ steps, summary }, note, hasPrice) {
  const errors = summary.diagnostics.filter(({ severity }) => severity === 'error').length
  const facts = `${count(steps.end.length)} moves, ${millimetres(steps.end.at(-1) ?? 0)}. Programmed: length ÷ feed, as CAM would say. Contour error: largest distance from the path.`
  const rate = make('a', { href: '#field-rates-hourly' }, 'Give the machine’s hourly rate')
  const unpriced = hasPrice ? [] : [' ', rate, ' to see prices; all of them are in the ', make('a', { href: '#quote' }, 'quote'), '.']
  const link = make(
    'a',
    { href: '#diagnostics', className: 'errors' },
    `${count(errors)} ${errors === 1 ? 'line' : 'lines'} could not be run as written. `,
  )
  return make('p', { className: 'about' }, ...(errors > 0 ? [link] : []), facts + note, ...unpriced)
}
