// The choice of a tolerance that a panel shows: the one that is quoted, until somebody chooses another one by hand.

import { columnLabel } from './columns.js'
import { make } from './dom.js'
import { lengthWord } from './format.js'

/** @import { Column } from "./types.js" */

/** @param {HTMLSelectElement} select @param {() => void} changed  another one is chosen by hand */
export function mountTolerance(select, changed) {
  /** @type {Column[]} */
  let columns = []
  let unit = ''
  /** What was chosen by hand; undefined: nothing. @type {Column | undefined} */
  let chosen

  select.addEventListener('change', () => {
    chosen = columns[select.selectedIndex]
    changed()
  })

  return {
    /** The tolerance that is shown; undefined where there is none. @returns {Column | undefined} */
    column: () => columns[select.selectedIndex],
    /** Offers tolerances. @param {Column[]} offered @param {Column} quoted */
    update(offered, quoted) {
      const isSame = unit === lengthWord() && offered.length === columns.length && offered.every((column, index) => column === columns[index])
      if (!isSame) select.replaceChildren(...offered.map((column) => make('option', {}, columnLabel(column))))
      columns = offered
      unit = lengthWord()
      if (chosen !== undefined && !columns.includes(chosen)) chosen = undefined
      select.selectedIndex = Math.max(columns.indexOf(chosen ?? quoted), 0)
    },
  }
}
