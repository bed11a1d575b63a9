// What would save time: settings of the control and feedrates that could be tried on an operation of the job that is open, and
// what the job would take with each. Every one is simulated and priced as the job itself is.

import { edited } from '../pkg/truefeed_whole.js'
import { columnLabel, columnsOf, machineOf, quotedColumn } from '../columns.js'
import { toleranceLabel } from '../labels.js'
import { say } from '../texts_later.js'
import { alike, around, pricedOther, takenBy } from './other.js'

/** @import { OtherJob, OtherOperation, Taken } from "./other.js" */
/** @import { Column, Cut, CutRoom, JobReport, Program, State, Value, Values } from "../types.js" */

/** What may be tried on an operation: another tolerance, or other values of its machine. @typedef {{key: string, title: string, program: Program, column?: Column, values?: Values}} Idea */

/** Distances within which controls smooth corners, mm, from level to level. */
const SMOOTHING_MM = [0.005, 0.01, 0.02, 0.05]
/** Lines that deviate by no more than this from one line are merged, mm. */
const MERGING_MM = 0.001
const SMOOTHING = 'interpolator.corner_smoothing_mm'
const MERGING = 'interpolator.path_smoothing_mm'
const CORNERS = 'interpolator.corner_mode'
const FEEDS = 'override.feed_by_line'

/** All that may be tried on an operation. @param {State} state @param {Program} program @returns {Idea[]} */
export function ideasFor(state, program) {
  const { values } = machineOf(state, program)
  const quoted = quotedColumn(state, program)
  const wider = quoted === null ? [] : columnsOf(state, program).filter((column) => column !== null && column > quoted)
  const next = quoted === null || wider.length > 0 ? wider : [2 * quoted]
  /** @type {Idea[]} */
  const ideas = next.map((column) => ({ key: 'tolerance', title: say.savings.tolerance(columnLabel(column)), program, column }))
  const add = (/** @type {string} */ title, /** @type {string} */ key, /** @type {Value} */ value) => {
    const changed = edited(JSON.stringify(values), key, JSON.stringify(value))
    if (changed) ideas.push({ key, title, program, values: JSON.parse(changed) })
  }
  const smoothing = SMOOTHING_MM.find((level) => level > Number(values[SMOOTHING] ?? 0))
  if (smoothing !== undefined) add(say.savings.smoothing(toleranceLabel(smoothing)), SMOOTHING, smoothing)
  if (Number(values[MERGING] ?? 0) < MERGING_MM) add(say.savings.merging(toleranceLabel(MERGING_MM)), MERGING, MERGING_MM)
  if (values[CORNERS] === 'paper') add(say.savings.guaranteed, CORNERS, 'guaranteed')
  else add(say.savings.paper, CORNERS, 'paper')
  const feeds = raised(state.cut, program)
  if (feeds) add(say.savings.feeds(feeds.places), FEEDS, { ...(typeof values[FEEDS] === 'object' ? values[FEEDS] : {}), ...feeds.factors })
  return ideas
}

/** Feedrates as high as tool and spindle allow, where the forces of a program were computed. @param {Cut | null} cut @param {Program} program */
function raised(cut, program) {
  const rooms = cut?.program === program.id ? cut.rooms.filter(({ factor, saved_s: saved }) => factor > 1 && saved > 0) : []
  if (rooms.length === 0) return undefined
  /** @type {Record<string, number>} */
  const factors = {}
  for (const {
    lines: [from, to],
    factor,
  } of inOrder(rooms)) {
    factors[`L${from}`] = factor
    factors[`L${to + 1}`] ??= 1
  }
  return { factors, places: rooms.length }
}

/** @param {CutRoom[]} rooms */
const inOrder = (rooms) => [...rooms].sort((a, b) => a.lines[0] - b.lines[0])

/** The job that is open with an idea in it. @param {State} state @param {Idea} idea @returns {OtherJob} */
function jobWith(state, idea) {
  const operations = state.programs.map((program) => {
    const own = alike(state, program)
    if (program !== idea.program) return own
    if (idea.column !== undefined) return { ...own, column: idea.column }
    return { ...own, machine: { start: '', values: /** @type {Values} */ (idea.values) } }
  })
  return { ...around(state), job: '', operations }
}

/** What is still to be computed for an idea: the operation in the job with it; undefined: nothing. @param {State} state @param {Idea} idea @returns {{job: OtherJob, operation: OtherOperation} | undefined} */
export function lacking(state, idea) {
  const job = jobWith(state, idea)
  const operation = job.operations.find((one) => !takenBy(state, job, one))
  return operation && { job, operation }
}

/** What an idea saves: of a part, s, and of the batch; null while something is to be computed. @param {State} state @param {Idea} idea @returns {{seconds: number, money: number} | null} */
export function savedBy(state, idea) {
  const job = jobWith(state, idea)
  const taken = job.operations.map((operation) => takenBy(state, job, operation))
  const report = state.price?.report
  if (!report || state.price?.faults || taken.some((one) => one === undefined)) return null
  const priced = pricedOther(job, /** @type {Taken[]} */ (taken))
  const other = /** @type {JobReport} */ (JSON.parse(priced.json()))
  priced.free()
  return { seconds: report.cycle_time_s - other.cycle_time_s, money: report.batch.total - other.batch.total }
}
