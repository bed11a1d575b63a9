// Another job beside the one that is open: the same on another machine, with other revisions of its programs, one that is kept in the
// browser, or one from a file; and what its programs take.

import { PricedJob, jobFromText, motionOf, programTitle, sniffedBytes } from '../pkg/truefeed_whole.js'
import { columnLabel, machineOf, quotedColumn } from '../columns.js'
import { say } from '../texts_later.js'
import { opened, planned, written } from './document.js'
import { nameOf } from './names.js'

/** @import { Engine } from "../engine.js" */
/** @import { OfJob, OwnMachine } from "./document.js" */
/** @import { Column, Form, Preset, Program, ProgramSummary, Run, State, Values } from "../types.js" */

/** An operation of it. @typedef {{name: string, title: string, file: Blob, dialect: string | null, machine: OwnMachine | null, column: Column, setUp: number | null, loading: number | null}} OtherOperation */
/** @typedef {OfJob & {values: Values, terms: Values, operations: OtherOperation[]}} OtherJob */
/** What an operation takes, at the tolerance that it was computed for, and what its program calls itself. @typedef {{summary: ProgramSummary, run: Run, column: Column, title: string}} Taken */

/** An operation that is open, as one of another job; it keeps what it is called, by which both belong together. @param {State} state @param {Program} program @returns {OtherOperation} */
export function alike(state, program) {
  const { name, file, dialect, machine, setUp, loading } = program
  const own = machine && { start: machine.start, values: machine.values }
  return { name, title: nameOf(program), file, dialect, machine: own, column: quotedColumn(state, program), setUp, loading }
}

/** What the job that is open is beside its operations. @param {State} state */
export const around = ({ fixture, letter, company, machine, terms }) => ({ fixture, letter, company, values: machine.values, terms: terms.values })

/** The job that is open on another machine. @param {State} state @param {Preset} preset @returns {OtherJob} */
export function onMachine(state, preset) {
  const operations = state.programs.map((program) => ({ ...alike(state, program), machine: null }))
  return { ...around(state), job: preset.name, values: preset.values, operations }
}

/** The job that is open with other revisions of its programs. Those of the same name take their places, the others first that of the operation that is in sight now and then those that are left. @param {State} state @param {readonly File[]} files @returns {(state: State) => OtherJob}  of a later state */
export function withPrograms(state, files) {
  const places = new Map(state.programs.map(({ id, name }) => [id, files.find((file) => file.name === name)]))
  const others = files.filter((file) => ![...places.values()].includes(file))
  const inSightFirst = [...state.programs].sort((a, b) => Number(b.id === state.selected) - Number(a.id === state.selected))
  for (const { id } of inSightFirst) if (!places.get(id)) places.set(id, others.shift())
  return (now) => {
    const operations = now.programs.map((program) => {
      const file = places.get(program.id)
      return { ...alike(now, program), ...(file ? { name: file.name, file } : {}) }
    })
    const column = quotedColumn(now, undefined)
    const added = others.map((file) => ({ name: file.name, title: '', file, dialect: null, machine: null, column, setUp: null, loading: null }))
    return { ...around(now), job: files.map(({ name }) => name).join(', '), operations: [...operations, ...added] }
  }
}

/** The job of a text. @param {string} text @param {Form} form Throws what is wrong with it, as text. @param {(name: string, index: number) => Blob} fileOf  its programs that are not in it @returns {OtherJob} */
export function fromText(text, form, fileOf) {
  const { tolerance: ofAll, ...job } = opened(JSON.parse(jobFromText(text)), form)
  const operations = job.operations.map((/** @type {any} */ { name, text: own, title, dialect, machine, tolerance, setUp, loading }, /** @type {number} */ index) => {
    const file = own === undefined ? fileOf(name, index) : new Blob([own])
    const column = tolerance ?? ofAll
    return { name, title, file, dialect, machine, column: column === 'programmed' ? null : column, setUp, loading }
  })
  return { ...job, operations }
}

/** The machine of an operation as its worker takes it. @param {OtherJob} job @param {OtherOperation} operation */
export const machineText = ({ values }, { machine }) => JSON.stringify(machine?.values ?? values)

/** What was computed, by program and then by how it was run. @type {WeakMap<Blob, Map<string, Taken>>} */
const known = new WeakMap()

/** How an operation is run, as text. @param {OtherJob} job @param {OtherOperation} operation */
const wayOf = (job, operation) => JSON.stringify([motionOf(machineText(job, operation)), operation.dialect, operation.column])

/** What an operation takes, where that is known: by an earlier comparison, or as it is open on the same machine. @param {State} state @param {OtherJob} job @param {OtherOperation} operation @returns {Taken | undefined} */
export function takenBy(state, job, operation) {
  const { file, dialect, column } = operation
  const found = known.get(file)?.get(wayOf(job, operation))
  if (found) return found
  const motion = motionOf(machineText(job, operation))
  const open = state.programs.find((one) => one.file === file && one.dialect === dialect && machineOf(state, one).motion === motion && one.outcome?.motion === motion)
  const run = open?.outcome?.runs.get(column)
  return open?.outcome && run ? { summary: open.outcome.summary, run, column, title: open.found } : undefined
}

/** Computes what an operation takes. A program that sets no tolerance is run at the first of those that are compared, as it would be if it were open. @param {Engine} engine @param {State} state @param {OtherJob} job @param {OtherOperation} operation */
export async function compute(engine, state, job, operation) {
  const { file: program, dialect } = operation
  const title = programTitle(new Uint8Array(await program.slice(0, sniffedBytes()).arrayBuffer())) ?? ''
  const machine = machineText(job, operation)
  for (const column of operation.column === null ? [null, state.tolerances[0]] : [operation.column]) {
    /** @type {ProgramSummary | undefined} */
    let summary
    /** @type {Run | undefined} */
    let run
    await engine.simulate({ program, machine, dialect, columns: [column], labels: [columnLabel(column)] }, { stage() {}, program: (told) => (summary = told), run: (_, told) => (run = told) })
    if (!summary || !run) continue
    const all = known.get(program) ?? new Map()
    known.set(program, all.set(wayOf(job, operation), { summary, run, column, title }))
    return
  }
  throw new Error(say.common.notComputed)
}

/** The price of a job whose operations are all computed. Throws what is wrong with its forms, as JSON. @param {OtherJob} job @param {Taken[]} taken */
export function pricedOther(job, taken) {
  const operations = job.operations.map((operation, index) => ({ ...operation, column: taken[index].column }))
  const programs = /** @type {Program[]} */ (/** @type {unknown} */ (taken.map(({ summary, run, column, title }) => ({ outcome: { summary, runs: new Map([[column, run]]) }, found: title, column }))))
  const runs = planned(programs, (program) => /** @type {any} */ (program).column)
  return new PricedJob(JSON.stringify({ job: written(job, operations, job), planned: runs }))
}
