// The columns of the results: the program's own tolerances where it sets any, then those of the user.

import { toleranceKey, toleranceLabel } from './labels.js'
import { say } from './texts.js'

/** @import { Filled } from "./plot.js" */
/** @import { Column, Held, Outcome, Program, State } from "./types.js" */

/** What a column is called. @param {Column} column */
export const columnLabel = (column) => (column === null ? say.charts.asProgrammed : toleranceLabel(column))

/** The name of a column in documents and in storage; it does not depend on the unit shown. @param {Column} column */
export const columnKey = (column) => (column === null ? say.charts.asProgrammed : toleranceKey(column))

/** The tolerance that an operation has of its own; undefined: that of the job, which also holds where a program sets none. @param {Program | undefined} program @returns {Column | undefined} */
function ownColumn(program) {
  const own = program?.tolerance ?? undefined
  return own === 'programmed' ? (program?.outcome?.held.length ? null : undefined) : own
}

/** Columns with one more, in order. @param {Column[]} columns @param {Column | undefined} own */
const withOwn = (columns, own) => (own === undefined || columns.includes(own) ? columns : [...columns, own].sort((a, b) => (a ?? 0) - (b ?? 0)))

/** What is shown of a program, in order. @param {State} state @param {Program | undefined} program @returns {Column[]} */
export function columnsOf({ programmed, tolerances }, program) {
  return withOwn(programmed && program?.outcome?.held.length ? [null, ...tolerances] : tolerances, ownColumn(program))
}

/** What is computed of a program before anybody knows whether it sets a tolerance. @param {State} state @param {Program} program @returns {Column[]} */
export function columnsUnread({ programmed, tolerances }, { tolerance }) {
  const isProgrammed = programmed || tolerance === 'programmed'
  return withOwn(isProgrammed ? [null, ...tolerances] : tolerances, typeof tolerance === 'number' ? tolerance : undefined)
}

/** The program in sight. @param {State} state */
export const programInSight = ({ programs, selected }) => programs.find(({ id }) => id === selected)

/** The machine that runs a program, that in sight by default: its own, or that of the form. @param {State} state */
export const machineOf = (state, program = programInSight(state)) => program?.machine ?? state.machine

/** The one of them that is quoted: that of the operation, else the one chosen for the job, else the first. @param {State} state @param {Program | undefined} program @returns {Column} */
export function quotedColumn(state, program) {
  const own = ownColumn(program)
  if (own !== undefined) return own
  const columns = columnsOf(state, program)
  return columns.find((column) => columnKey(column) === state.quoted) ?? columns[0]
}

/** Whether what is made is more than a program that is run part by part. @param {Pick<State, "programs" | "fixture">} state */
export const isJob = ({ programs, fixture }) => programs.length > 1 || (fixture ?? 1) > 1

/** What an operation takes of the time of a part, s: parts on a fixture share its tool changes. @param {State} state @param {Program} program */
export function cycleOf(state, program) {
  const shared = state.price?.report.operations[state.programs.indexOf(program)]?.cycle_time_s
  const alone = (state.fixture ?? 1) > 1 ? undefined : program.outcome?.runs.get(quotedColumn(state, program))?.summary.cycle_time_s
  return shared ?? alone
}

/** Whether there is nothing to compute: no move, and no time without one. @param {Outcome | null | undefined} outcome */
export const isStill = (outcome) => Boolean(outcome && outcome.steps.end.length === 0 && outcome.summary.programmed_time_s === 0)

/** Puts a column in a chart, as a curve that is empty until it is filled. @param {Filled} chart @param {Column} column @param {Held[]} held  the program's own tolerances @param {string} [label] */
export function addCurve(chart, column, held, label = columnLabel(column)) {
  const parts = column === null ? held : [{ distance_mm: [0, Infinity], tolerance_mm: column }]
  const [from, to] = [0, 1].map((end) => Float64Array.from(parts, ({ distance_mm: ends }) => ends[end]))
  chart.add(
    label,
    from,
    to,
    Float64Array.from(parts, ({ tolerance_mm: tolerance }) => tolerance),
  )
}
