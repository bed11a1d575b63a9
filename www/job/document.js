// What is open as a job in its own format (docs/job.schema.json), and back. Rust checks what comes from a file, and prices.

/** @import { Column, Form, OwnTolerance, Program, State, Value, Values } from "../types.js" */

/** A machine of an operation's own: the one it began as, and its values. @typedef {{start: string, values: Values}} OwnMachine */
/** What an operation of a job has beside its program. @typedef {{title: string, machine: OwnMachine | null, tolerance: OwnTolerance, setUp: number | null, loading: number | null}} OfOperation */
/** What a job has beside its operations. @typedef {{job: string, fixture: number | null, letter: Values, company: Values}} OfJob */

/** An operation with its program. @typedef {Omit<OfOperation, "tolerance"> & {name: string, dialect: string | null, column: Column, text?: string}} Written */

/** A job without anything. @returns {OfJob} */
export const nothing = () => ({ job: '', fixture: null, letter: {}, company: {} })

/** Entries that say something. @param {Values} values */
const said = (values) => Object.fromEntries(Object.entries(values).filter(([, value]) => value !== null && value !== ''))

/**
 * A job as its file says it; the version comes first, by which a file is known for a job.
 * @param {OfJob} job
 * @param {readonly Written[]} operations
 * @param {{values: Values, terms: Values}} forms  the machine of all, and the terms
 */
export function written({ job, fixture, letter, company }, operations, { values, terms }) {
  const one = (/** @type {Written} */ { name, title, machine, setUp, loading, dialect, column, text }) => ({
    program: name,
    ...(title ? { name: title } : {}),
    ...(machine ? { machine: said(machine.values) } : {}),
    tolerance_mm: column,
    ...words(dialect),
    ...(setUp === null ? {} : { set_up_min: setUp }),
    ...(loading === null ? {} : { loading_s: loading }),
    ...(text === undefined ? {} : { text }),
  })
  return {
    truefeed_job: 1,
    ...(job ? { name: job } : {}),
    machine: said(values),
    ...(fixture ? { fixture: { parts: fixture } } : {}),
    terms: said(terms),
    operations: operations.map(one),
    offer: said(letter),
    company: said(company),
  }
}

/** How a program is read, by the words that choose it. @param {string | null} dialect  a dialect, what arcs count from, or both */
function words(dialect) {
  const all = dialect?.split(' ') ?? []
  const centres = all.find((word) => CENTRES.includes(word))
  const control = all.find((word) => !CENTRES.includes(word))
  return { ...(control ? { dialect: control } : {}), ...(centres ? { arc_centres: centres } : {}) }
}

const CENTRES = ['incremental', 'absolute']

/**
 * A job that Rust has read, as what is open: its programs, machine, tolerance and terms. Each operation says everything
 * itself there; what all of them say alike is the job's.
 * @param {any} job  as `jobFromText` gives it
 * @param {Form} form
 */
export function opened(job, form) {
  const machines = job.operations.map((/** @type {any} */ { machine }) => filled(machine, form))
  const alike = machines.every((/** @type {Values} */ values) => JSON.stringify(values) === JSON.stringify(machines[0]))
  const tolerances = job.operations.map((/** @type {any} */ { tolerance_mm: tolerance }) => tolerance ?? 'programmed')
  const parts = job.operations.map((/** @type {any} */ { fixture }) => fixture?.parts ?? null)
  return {
    job: job.name ?? '',
    fixture: parts[0],
    letter: job.offer ?? {},
    company: job.company ?? {},
    terms: job.terms ?? {},
    values: machines[0],
    tolerance: /** @type {number | 'programmed'} */ (tolerances[0]),
    operations: job.operations.map((/** @type {any} */ operation, /** @type {number} */ index) => ({
      name: operation.program.split(/[\\/]/).pop(),
      path: operation.program,
      text: operation.text,
      title: operation.name ?? '',
      dialect: [operation.dialect, operation.arc_centres].filter(Boolean).join(' ') || null,
      machine: alike || index === 0 ? null : { start: String(machines[index].name ?? ''), values: machines[index] },
      tolerance: tolerances[index] === tolerances[0] ? null : tolerances[index],
      setUp: operation.set_up_min ?? null,
      loading: operation.loading_s ?? null,
    })),
  }
}

/** All values of a machine, of which a job says what is not neutral. @param {Values} own @param {Form} form @returns {Values} */
function filled(own, form) {
  return Object.fromEntries(form.fields.map(({ key, neutral }) => [key, key in own ? own[key] : neutral]))
}

/**
 * What the programs of a job take, as Rust asks for it; null where one is not there yet.
 * @param {readonly Program[]} programs
 * @param {(program: Program) => Column} columnOf  the tolerance that is quoted
 */
export function planned(programs, columnOf) {
  const all = programs.map((program) => {
    const run = program.outcome?.runs.get(columnOf(program))
    if (!program.outcome || !run) return null
    const { programmed_time_s, diagnostics } = program.outcome.summary
    const count = (/** @type {string} */ kind) => diagnostics.filter(({ severity }) => severity === kind).length
    const { tolerance_mm, breakdown, operations, range, trust, in_doubt } = run.summary
    const remarks = { errors: count('error'), warnings: count('warning') }
    return { title: /** @type {any} */ (program).found ?? '', programmed_time_s, tolerance_mm, breakdown, operations, range, trust, in_doubt, remarks }
  })
  return all.every((one) => one !== null) ? all : null
}
