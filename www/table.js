// The table behind a chart: what is in sight in rows, for those who do not see the chart or want its numbers.

import { make, scroll } from './dom.js'
import { amount, feedNumber, inLengthUnit, lengthSymbols } from './format.js'
import { deviationLabel } from './labels.js'
import { say } from './texts_later.js'

/** @import { Chart } from "./pkg/truefeed_whole.js" */

/** @param {Chart} chart @param {string} caption */
export function tableOf(chart, caption) {
  const isOverTime = chart.isOverTime()
  const inUnit = (/** @type {number} */ at) => (isOverTime ? at : inLengthUnit(at))
  const [length, perMinute] = lengthSymbols()
  const labels = chart.labels()
  const rows = chart.table()
  const place = written(
    rows.map(({ to }) => inUnit(to)),
    isOverTime ? ' s' : '',
  )
  const lateness = written(
    rows.flatMap(({ lost, lostAfter }) => [lost, lostAfter]).filter((value) => value !== undefined),
    ' s',
  )
  const range = (/** @type {ArrayLike<number>} */ pair, write = feedNumber) => (pair.length > 0 ? between(write(pair[0]), write(pair[1])) : '–')
  const told = (/** @type {number | undefined} */ value, /** @type {(value: number) => string} */ write) => (value === undefined ? '–' : write(value))
  const hasErrors = labels.map((_, index) => rows.some(({ curves }) => curves[index].error !== undefined))
  const hasLost = rows.some(({ lost }) => lost !== undefined)
  const hasAfter = rows.some(({ lostAfter }) => lostAfter !== undefined)
  const titles = [
    isOverTime ? say.common.time : say.charts.distanceIn(length),
    say.common.lines,
    say.charts.inMinutes(say.common.programmed, perMinute),
    ...labels.flatMap((label, index) => [say.charts.inMinutes(label, perMinute), ...(hasErrors[index] ? [say.charts.errorOf(label)] : [])]),
    ...(hasLost ? [say.charts.lost] : []),
    ...(hasAfter ? [say.charts.lostAfter] : []),
  ]
  const body = rows.map(({ from, to, lines, programmed, curves, lost, lostAfter }) => {
    const cells = [range(lines, String), range(programmed)]
    for (const [index, { feedrate, error }] of curves.entries()) {
      cells.push(range(feedrate))
      if (hasErrors[index]) cells.push(told(error, deviationLabel))
    }
    if (hasLost) cells.push(told(lost, lateness))
    if (hasAfter) cells.push(told(lostAfter, lateness))
    const head = make('th', { scope: 'row' }, between(place(inUnit(from)), place(inUnit(to))))
    return make('tr', {}, head, ...cells.map((cell) => make('td', {}, cell)))
  })
  const head = make('tr', {}, ...titles.map((title) => make('th', { scope: 'col' }, title)))
  return scroll(make('table', {}, make('caption', {}, caption), make('thead', {}, head), make('tbody', {}, ...body)))
}

/** More decimals tell of no machine. */
const MOST_DECIMALS = 6

/** Writes numbers with as many decimals as tell one row from the next. @param {number[]} values  of a column @param {string} unit */
function written(values, unit) {
  const step = (Math.max(...values) - Math.min(...values)) / Math.max(values.length - 1, 1)
  const decimals = Math.min(Math.max(1 - Math.floor(Math.log10(step || 1)), 1), MOST_DECIMALS)
  return (/** @type {number} */ value) => amount(value, decimals) + unit
}

/** A range, or what both of its ends are. @param {string} from @param {string} to */
const between = (from, to) => (from === to ? from : `${from} – ${to}`)
