// Where two revisions of a program differ: lines, time and path, what differs most first.

import { find, make } from '../dom.js'
import { count, difference, lengthLabel, seconds } from '../format.js'
import { say } from '../texts_later.js'

/** @import { RevisedRow, RevisionsReport } from "../types.js" */

/** @param {HTMLElement} place */
export function mount(place) {
  /**
   * @param {RevisionsReport} report
   * @param {string[]} names  of both programs
   * @param {(stretch: [number, number]) => void} mark  shows where lines are on the path
   */
  function fill(report, names, mark) {
    const isAlike = report.runs.length === 0
    const told = !isAlike ? [] : [make('p', {}, report.is_same ? say.against.sameProgram : say.against.sameTime)]
    const rows = report.runs.map((row) => line(row, mark))
    const [first, second] = names
    const titles = [first, second, say.against.what, first, second, say.common.difference, first, second]
    const heads = make('tr', {}, ...groups())
    const table = make(
      'table',
      {},
      make('caption', {}, say.against.whereCaption),
      make('thead', {}, heads, make('tr', {}, ...titles.map((title) => make('th', { scope: 'col', title }, title)))),
      make('tbody', {}, ...rows, ...elsewhere(report.elsewhere_s)),
    )
    place.replaceChildren(make('h3', {}, say.against.where), ...told, ...(isAlike ? [] : [scroll(table)]))
  }

  return {
    fill,
    /** Says what there is instead. @param {string} [words] */
    empty(words) {
      place.replaceChildren(...(words ? [make('h3', {}, say.against.where), make('p', { className: 'small' }, words)] : []))
    },
  }
}

/** What the columns are of. */
const groups = () =>
  [
    [say.common.lines, 2],
    ['', 1],
    [say.common.time, 3],
    [say.against.path, 2],
  ].map(([text, columns]) => (text ? make('th', { scope: 'colgroup', colSpan: Number(columns) }, String(text)) : make('td', {})))

/** @param {[number, number] | null} lines */
const linesOf = (lines) => (lines === null ? '–' : lines[0] === lines[1] ? count(lines[0]) : `${count(lines[0])}–${count(lines[1])}`)

/** @param {RevisedRow} row @param {(stretch: [number, number]) => void} mark */
function line({ lines, is_same: isSame, seconds: times, difference_s: by, length_mm: lengths, distance_mm: distance }, mark) {
  const kind = isSame ? say.against.unchanged : lines[0] === null ? say.against.added : lines[1] === null ? say.against.removed : say.against.changed
  const show = make('button', { type: 'button', title: say.common.showInCharts }, linesOf(lines[1]))
  show.addEventListener('click', () => distance && mark(distance))
  const where = make('td', {}, distance ? show : linesOf(lines[1]))
  const told = (/** @type {number[]} */ values, /** @type {(value: number) => string} */ write) => values.map((value, side) => (lines[side] === null ? '–' : write(value)))
  const others = [kind, ...told(times, seconds), difference(by), ...told(lengths, lengthLabel)]
  return make('tr', {}, make('th', { scope: 'row' }, linesOf(lines[0])), where, ...others.map((text) => make('td', {}, text)))
}

/** What all other lines differ by together. @param {number} by */
function elsewhere(by) {
  const cells = ['', '', '', '', difference(by), '', '']
  return /[1-9]/.test(difference(by)) ? [make('tr', { className: 'elsewhere' }, make('th', { scope: 'row' }, say.path.everywhereElse), ...cells.map((text) => make('td', {}, text)))] : []
}

/** What is wider than the page is scrolled by itself. @param {HTMLElement} table */
function scroll(table) {
  const place = make('div', { className: 'scroll', tabIndex: 0 }, table)
  place.setAttribute('role', 'group')
  place.setAttribute('aria-label', find(table, 'caption').textContent ?? '')
  return place
}
