// The tables of a recording: motion and waiting beside the simulation, and where time was lost. Nobody needs them before there
// is a recording.

import { make, scroll } from '../dom.js'
import { count, difference, percent, seconds } from '../format.js'
import { lostLabel } from '../labels.js'
import { say } from '../texts_later.js'

/** @import { ComparisonReport, Place } from "../types.js" */

/** @param {string} caption @param {string[]} titles @param {HTMLElement[]} rows */
function table(caption, titles, rows) {
  const head = titles.map((title) => (title ? make('th', { scope: 'col' }, title) : make('td', {})))
  const title = make('caption', {}, caption)
  const body = make('table', {}, title, make('thead', {}, make('tr', {}, ...head)), make('tbody', {}, ...rows))
  return scroll(body)
}

/** How far the simulated time is from the recorded one. @param {number} recorded @param {number} simulated */
function apart(recorded, simulated) {
  const ratio = recorded > 0 ? ` (${percent(simulated / recorded - 1)})` : ''
  return `${difference(simulated - recorded)}${ratio}`
}

/** @param {ComparisonReport} report */
export function partsTable(report) {
  const whole = { name: say.common.together, is_detail: false, recorded_s: report.recorded_s, simulated_s: report.simulated_s }
  const rows = [...report.parts, whole].map(({ name, is_detail: isDetail, recorded_s: recorded, simulated_s: simulated }) =>
    make('tr', { className: isDetail ? 'detail' : '' }, make('th', { scope: 'row' }, name), ...[seconds(recorded), seconds(simulated), apart(recorded, simulated)].map((cell) => make('td', {}, cell))),
  )
  const all = table(say.recording.motionWaiting, ['', say.recording.recorded, say.recording.simulated, say.common.difference], rows)
  all.append(make('p', { className: 'help' }, say.recording.divided))
  return all
}

/** @param {ComparisonReport} report @param {(place: Pick<Place, 'distance_mm'>) => void} show */
export function stretchesTable({ stretches, all_stretches: all }, show) {
  const rows = stretches.map((stretch) => {
    const [from, to] = stretch.lines
    const go = make('button', { type: 'button', title: say.common.showInCharts }, from === to ? `${from}` : `${from}–${to}`)
    go.addEventListener('click', () => show(stretch))
    const cells = [lostLabel(stretch.seconds), seconds(stretch.recorded_s), seconds(stretch.simulated_s)]
    return make('tr', {}, make('td', {}, go), ...cells.map((cell) => make('td', {}, cell)), make('td', { className: 'kind' }, stretch.kind))
  })
  const which = stretches.length < all ? say.recording.largestOf(count(stretches.length), count(all)) : ''
  return table(say.recording.whereLost(which), [say.common.lines, say.common.lost, say.recording.recorded, say.recording.simulated, say.recording.while], rows)
}
