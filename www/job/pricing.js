// The price of the job that is open: what its programs take, as Rust asks for it. The state holds it for all panels.

import { PricedJob } from '../pkg/truefeed_whole.js'
import { machineOf, quotedColumn } from '../columns.js'
import { planned, written } from './document.js'

/** @import { JobReport, Program, State, Values } from "../types.js" */

/**
 * A job with its times and its price. Where an entry of its forms has a fault, only the times are there: `job` is null and `faults`
 * says what is wrong, as JSON.
 * @typedef {{job: PricedJob | null, report: JobReport, faults: string}} Price
 */

/** Whether a program is computed on its machine as that is now. @param {State} state @param {Program} program */
export const isCurrent = (state, program) => program.outcome?.motion === machineOf(state, program).motion

/** All that the price depends on, to be compared. @param {State} state @returns {unknown[]} */
const dependsOn = (state) => [
  state.machine.values,
  state.terms.values,
  state.job,
  state.fixture,
  state.letter,
  state.company,
  ...state.programs.flatMap((program) => {
    const { name, title, found, machine, setUp, loading, outcome } = program
    return [name, title, found, machine, setUp, loading, outcome, outcome?.runs.get(quotedColumn(state, program))]
  }),
]

/** Prices the job that is open; the price is the same object until something that it depends on changes. */
export function pricing() {
  /** @type {unknown[]} */
  let from = []
  /** @type {Price | null} */
  let price = null

  return (/** @type {State} */ state) => {
    const now = dependsOn(state)
    if (now.length === from.length && now.every((value, index) => value === from[index])) return price
    from = now
    price?.job?.free()
    price = priced(state)
    return price
  }
}

/** The price; null where a program is still to be computed. @param {State} state @returns {Price | null} */
function priced(state) {
  const columnOf = (/** @type {Program} */ program) => quotedColumn(state, program)
  const isComputed = state.programs.length > 0 && state.programs.every((program) => isCurrent(state, program))
  const runs = isComputed ? planned(state.programs, columnOf) : null
  if (!runs) return null
  const operations = state.programs.map((program) => ({ ...program, column: columnOf(program) }))
  /** @param {Pick<State, "letter" | "company">} documents @param {Values} terms */
  const jobWith = (documents, terms) => {
    const job = written({ ...state, ...documents }, operations, { values: state.machine.values, terms })
    return new PricedJob(JSON.stringify({ job, planned: runs }))
  }
  const reportOf = (/** @type {PricedJob} */ job) => /** @type {JobReport} */ (JSON.parse(job.json()))
  try {
    const job = jobWith(state, state.terms.values)
    return { job, report: reportOf(job), faults: '' }
  } catch (faults) {
    if (typeof faults !== 'string') throw faults
    const wrong = new Set(state.terms.faults.map(({ key }) => key))
    const valid = Object.fromEntries(Object.entries(state.terms.values).filter(([key]) => !wrong.has(key)))
    const job = jobWith({ letter: {}, company: {} }, valid)
    const report = reportOf(job)
    job.free()
    return { job: null, report, faults }
  }
}
