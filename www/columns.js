// The columns of the results: the program's own tolerances where it sets any, then those of the user.

import { toleranceLabel } from './pkg/truefeed.js'
import { say } from './texts.js'

/** @import { Column, Outcome, State } from "./types.js" */

/** What a column is called. @param {Column} column */
export const columnLabel = (column) => (column === null ? say.charts.asProgrammed : toleranceLabel(column))

/** What is shown of a program, in order. @param {State} state @param {Outcome | null | undefined} outcome @returns {Column[]} */
export function columnsOf({ programmed, tolerances }, outcome) {
  return programmed && outcome && outcome.held.length > 0 ? [null, ...tolerances] : tolerances
}
