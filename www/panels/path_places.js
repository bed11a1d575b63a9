// The places that cost most: numbers on the path, and a table of them below it.

import { columnLabel } from '../columns.js'
import { make } from '../dom.js'
import { lengthWord, number, percent, worded } from '../format.js'
import { say } from '../texts_later.js'

/** @import { Column, LostAt, Run } from "../types.js" */

/**
 * @param {HTMLElement} list
 * @param {HTMLElement} marks
 * @param {(place: LostAt) => void} chosen
 */
export function mountPlaces(list, marks, chosen) {
  /** @type {LostAt[]} */
  let places = []
  /** @type {LostAt | undefined} */
  let current

  /** Marks one of them, or none. @param {LostAt | undefined} place */
  function choose(place) {
    current = place
    const index = place ? places.indexOf(place) : -1
    for (const [row, element] of [...list.querySelectorAll('tbody tr')].entries()) {
      if (row === index) element.setAttribute('aria-current', 'true')
      else element.removeAttribute('aria-current')
    }
    for (const [row, element] of [...marks.children].entries()) element.classList.toggle('chosen', row === index)
  }

  return {
    choose,
    /** @param {Run | undefined} run @param {Column} column */
    fill(run, column) {
      places = run?.summary.lost.places ?? []
      marks.replaceChildren(
        ...places.map(({ distance_mm: [from, to] }, index) => {
          const mark = make('span', {}, String(index + 1))
          mark.dataset.at = String(0.5 * (from + to))
          return mark
        }),
      )
      if (!run) return list.replaceChildren(make('p', { className: 'empty' }, say.common.computing))
      const { seconds: all, elsewhere_s: elsewhere } = run.summary.lost
      const texts = lengthWord() === 'inch' ? run.placesInInches : places.map(({ text }) => text)
      const cells = (/** @type {number} */ lostHere) => [make('td', {}, `${number(lostHere)} s`), make('td', {}, all > 0 ? percent(lostHere / all).replace('+', '') : '–')]
      const rows = places.map((place, index) => {
        const [from, to] = place.lines
        const go = make('button', { type: 'button', title: say.path.showEverywhere }, from === to ? `${from}` : `${from}–${to}`)
        go.setAttribute('aria-label', say.path.showPlace(index + 1, go.textContent))
        go.addEventListener('click', () => chosen(place))
        return make('tr', {}, make('th', { scope: 'row' }, String(index + 1)), make('td', {}, go), make('td', {}, worded(texts[index])), ...cells(place.seconds))
      })
      const rest = make('tr', {}, make('th', { scope: 'row', colSpan: 3 }, say.path.everywhereElse), ...cells(elsewhere))
      const total = make('tr', {}, make('th', { scope: 'row', colSpan: 3 }, say.path.total), ...cells(all))
      const titles = ['', say.common.lines, say.path.why, say.common.lost, say.path.ofAll].map((title) => make('th', { scope: 'col' }, title))
      titles[0].append(make('span', { className: 'away' }, say.path.place))
      const which = column === null ? columnLabel(column) : say.path.atTolerance(columnLabel(column))
      const caption = make('caption', {}, places.length > 0 ? say.path.costliest(which) : say.path.nothingLost(which))
      const scroll = make(
        'div',
        { className: 'scroll', tabIndex: 0 },
        make('table', {}, caption, make('thead', {}, make('tr', {}, ...titles)), make('tbody', {}, ...rows), make('tfoot', {}, rest, total)),
      )
      scroll.setAttribute('role', 'group')
      scroll.setAttribute('aria-label', say.path.costliestLabel)
      list.replaceChildren(scroll)
      choose(places.find((place) => place === current))
    },
    empty() {
      marks.replaceChildren()
      list.replaceChildren()
    },
  }
}
