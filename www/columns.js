// The columns of the results: the program's own tolerances where it sets any, then those of the user.

import { toleranceLabel } from './labels.js'
import { say } from './texts.js'

/** @import { Filled } from "./plot.js" */
/** @import { Column, Held, Outcome, State } from "./types.js" */

/** What a column is called. @param {Column} column */
export const columnLabel = (column) => (column === null ? say.charts.asProgrammed : toleranceLabel(column))

/** What is shown of a program, in order. @param {State} state @param {Outcome | null | undefined} outcome @returns {Column[]} */
export function columnsOf({ programmed, tolerances }, outcome) {
  return programmed && outcome && outcome.held.length > 0 ? [null, ...tolerances] : tolerances
}

/** Whether there is nothing to compute: no move, and no time without one. @param {Outcome | null | undefined} outcome */
export const isStill = (outcome) => Boolean(outcome && outcome.steps.end.length === 0 && outcome.summary.programmed_time_s === 0)

/** Puts a column in a chart, as a curve that is empty until it is filled. @param {Filled} chart @param {Column} column @param {Held[]} held  the program's own tolerances */
export function addCurve(chart, column, held) {
  const parts = column === null ? held : [{ distance_mm: [0, Infinity], tolerance_mm: column }]
  const [from, to] = [0, 1].map((end) => Float64Array.from(parts, ({ distance_mm: ends }) => ends[end]))
  chart.add(columnLabel(column), from, to, Float64Array.from(parts, ({ tolerance_mm: tolerance }) => tolerance))
}
