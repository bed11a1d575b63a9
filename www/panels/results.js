// The table of cycle times, one row a tolerance.

import { deviationLabel, toleranceLabel } from '../pkg/truefeed.js'
import { find, make } from '../dom.js'
import { clock, count, difference, millimetres, money, percent, seconds } from '../format.js'

/** @import { Outcome, State } from "../types.js" */

/** @type {[keyof import("../types.js").RunSummary["breakdown"], string][]} */
const PARTS = [
  ['cutting_s', 'Cutting'],
  ['rapid_s', 'Rapid'],
  ['dwell_s', 'Dwell'],
  ['tool_change_s', 'Tool change'],
  ['other_s', 'Other'],
]

/** @param {HTMLElement} root */
export function mount(root) {
  const place = find(root, '.table')
  return {
    /** @param {State} state */
    update(state) {
      const program = state.programs.find(({ id }) => id === state.selected)
      const outcome = program?.outcome
      const stale = Boolean(outcome) && outcome?.machine !== JSON.stringify(state.machine.values)
      root.classList.toggle('stale', stale)
      if (program && outcome) {
        place.replaceChildren(
          table(outcome, state.tolerances),
          about(program.name, outcome, stale ? outOfDate(state) : ''),
        )
      } else {
        place.replaceChildren(make('p', { className: 'empty' }, state.progress ? 'Computing …' : 'Not computed yet.'))
      }
    },
  }
}

/** @param {Outcome} outcome @param {number[]} tolerances */
function table(outcome, tolerances) {
  const priced = [...outcome.runs.values()].some(({ summary }) => summary.price)
  /** @type {[string, number][]} */
  const titles = [['Tolerance', 1], ['Cycle time', 2], ...priceTitles(priced), ['Programmed', 1], ['Difference', 2]]
  for (const [, title] of PARTS) titles.push([title, 1])
  titles.push(['Path error', 1])
  const head = make('tr', {}, ...titles.map(([title, colSpan]) => make('th', { scope: 'col', colSpan }, title)))
  const programmed = outcome.summary.programmed_time_s
  const rows = tolerances.map((tolerance, index) => {
    const label = make(
      'th',
      { scope: 'row' },
      make('span', { className: `swatch curve-${index}` }),
      toleranceLabel(tolerance),
    )
    const run = outcome.runs.get(tolerance)?.summary
    if (!run) return make('tr', { className: 'waiting' }, label, make('td', { colSpan: titles.length + 1 }, '…'))
    const longer = run.cycle_time_s - programmed
    const cells = [
      make('data', { value: String(run.cycle_time_s) }, clock(run.cycle_time_s)),
      seconds(run.cycle_time_s),
      ...(priced ? [make('b', { className: 'price' }, money(run.price))] : []),
      seconds(programmed),
      difference(longer),
      percent(longer / programmed),
      ...PARTS.map(([key]) => seconds(run.breakdown[key])),
      deviationLabel(run.max_contour_error_mm),
    ]
    return make('tr', {}, label, ...cells.map((cell) => make('td', {}, cell)))
  })
  const table = make('table', {}, make('thead', {}, head), make('tbody', {}, ...rows))
  return make('div', { className: 'scroll' }, table)
}

/** @param {boolean} priced @returns {[string, number][]} */
const priceTitles = (priced) => (priced ? [['Price', 1]] : [])

/** Why the results in sight are not those of the machine in the form. @param {State} state */
function outOfDate({ machine, paused }) {
  if (machine.faults.length > 0) return ' These are the results of the machine before: the form has a fault.'
  return paused ? ' These are the results of the machine before.' : ' Computing anew for the changed machine …'
}

/** @param {string} name @param {Outcome} outcome @param {string} note */
function about(name, { steps, summary }, note) {
  const errors = summary.diagnostics.filter(({ severity }) => severity === 'error').length
  const facts = `${name}: ${count(steps.end.length)} moves, ${millimetres(steps.end.at(-1) ?? 0)}. Programmed: length ÷ feed, as CAM would say. Path error: largest distance from the path; corners close together can exceed the tolerance.`
  const link = make(
    'a',
    { href: '#diagnostics' },
    `${count(errors)} ${errors === 1 ? 'line' : 'lines'} could not be run as written. `,
  )
  return make('p', { className: 'about' }, ...(errors > 0 ? [link] : []), facts + note)
}
