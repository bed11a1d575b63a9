// Does what waits, one after the other: simulations, comparisons, diagnoses, calibrations. What it finds it puts in the state.

import { motionOf } from './pkg/truefeed.js'
import { columnLabel, columnsOf, columnsUnread, machineOf } from './columns.js'
import { Ended, LARGE_BYTES, unlessCancelled } from './engine.js'
import { candidates, evidence, isToPair, namesake, programFor, usable } from './recordings.js'
import { say } from './texts.js'

/** @import { Before, Calibration, Column, Outcome, Program, Recording, State } from "./types.js" */

/**
 * What the page does meanwhile.
 * @typedef {object} Page
 * @property {() => void} update  shows what has changed
 * @property {() => void} progress  shows how far the work is
 * @property {(message: string) => void} fail  says what should not happen
 * @property {() => void} hasCurve  a curve is there
 * @property {(recording: number, program: number | null) => void} paired  it is known which program a recording is of
 * @property {() => Before} now  what is in the form
 * @property {(calibration: Calibration) => void} take  puts a calibrated machine in the form
 */

/** Why something failed; a worker that does not start does not say. @param {unknown} error */
const reasonOf = (error) => (error instanceof Error ? error.message || say.work.noWorker : String(error))

/** @param {State} state @param {import("./engine.js").Engine} engine @param {Page} page @returns {() => Promise<void>} does all that waits */
export function workOn(state, engine, page) {
  /** The columns a program still lacks on the machine as it is now. @param {Program} program @returns {Column[]} */
  function missing(program) {
    const current = program.outcome?.motion === machineOf(state, program).motion ? program.outcome : null
    if (current) return columnsOf(state, program).filter((column) => !current.runs.has(column))
    // Whether it sets a tolerance is known when it is read.
    return columnsUnread(state, program)
  }

  /** Does all that waits, that of the selected program first. */
  async function work() {
    if (state.progress) return
    for (;;) {
      const selectedFirst = [...state.programs].sort((a, b) => Number(b.id === state.selected) - Number(a.id === state.selected))
      const { motion } = state.machine
      const waits = (/** @type {Program} */ candidate) => {
        const { motion: own } = machineOf(state, candidate)
        return own !== undefined && missing(candidate).length > 0 && candidate.failure !== own
      }
      const program = selectedFirst.find(waits)
      const recording = selectedFirst
        .flatMap(({ id }) => state.recordings.filter((candidate) => candidate.program === id))
        .find(({ match, failure }) => motion !== undefined && match?.motion !== motion && failure !== motion)
      // The one in sight first, and each is compared before the next is looked at.
      const lost = motion === undefined ? undefined : inSightFirst(state.recordings).find((one) => isToPair(one, state))
      if (state.paused || (motion === undefined && !program)) break
      // What is in sight comes first, its simulation before its comparison.
      const compares = recording && (!program || (recording.program === state.selected && program.id !== state.selected))
      if (state.calibrating) {
        if (!(await calibrate())) break
      } else if (state.diagnosing && !recording && !lost) {
        // What it is made from has been compared by now.
        if (!(await diagnose())) break
      } else if (compares) {
        if (!(await compare(recording, String(motion)))) break
      } else if (lost && program?.id !== state.selected) {
        if (!(await pair(lost))) break
      } else if (program) {
        if (!(await simulate(program))) break
      } else break
    }
    state.progress = null
    page.update()
  }

  /** Simulates what one program lacks; false where that was cancelled. @param {Program} program */
  async function simulate(program) {
    const { values, motion } = machineOf(state, program)
    const machine = JSON.stringify(values)
    const columns = missing(program)
    const isForOther = program.outcome !== null && program.outcome.motion !== motion
    /** @type {Outcome | null} */
    let outcome = null
    const stage = stageOf(program.id)
    stage('starting', 0)
    const listener = {
      stage,
      program(/** @type {any} */ summary, /** @type {any} */ steps, /** @type {any} */ held, /** @type {any} */ trail) {
        outcome = { motion: String(motion), summary, steps, held, trail, runs: new Map(isForOther ? [] : program.outcome?.runs) }
        // What was computed for another machine stays in sight until all is there.
        if (isForOther) return
        program.outcome = outcome
        // What is programmed can be drawn before anything is simulated.
        page.update()
      },
      run(/** @type {Column} */ column, /** @type {any} */ run) {
        outcome?.runs.set(column, run)
        page.update()
        page.hasCurve()
      },
    }
    const labels = columns.map(columnLabel)
    return tried(
      async () => {
        const request = { program: program.file, machine, dialect: program.dialect, columns, labels }
        const gains = 1 < columns.length && 1 < navigator.hardwareConcurrency && LARGE_BYTES < program.file.size
        const several = gains && (await engine.until(import('./side_by_side.js')).catch(unlessCancelled))
        await (several ? several.simulate(engine, request, listener) : engine.simulate(request, listener))
        program.outcome = outcome
        program.failure = null
      },
      (reason) => {
        program.failure = String(motion)
        page.fail(say.work.notSimulated(program.name, reason))
      },
    )
  }

  /** Does one thing of all; false where that was cancelled. @param {() => Promise<void>} what @param {(reason: string) => void} failed */
  async function tried(what, failed) {
    try {
      page.update()
      await what()
    } catch (error) {
      if (error instanceof Ended && error.kind === 'cancelled') return false
      failed(reasonOf(error))
    }
    return true
  }

  /** Tells the progress of work on a program, or on several. @param {number | null} program @returns {import("./engine.js").Stage} */
  function stageOf(program) {
    return (stage, part, name) => {
      const text = say.stages[stage]
      state.progress = { program, stage: typeof text === 'string' ? text : text(name), part }
      page.progress()
    }
  }

  /** @param {Recording[]} recordings */
  const inSightFirst = (recordings) => [...recordings].sort((a, b) => Number(b.id === state.recording) - Number(a.id === state.recording))

  /** Finds which program a recording is of, by what it holds; false where that was cancelled. @param {Recording} recording */
  async function pair(recording) {
    const stage = stageOf(null)
    const programs = [...state.programs]
    const of = candidates(programs)
    stage('pairing', 0, recording.name)
    const machine = JSON.stringify(state.machine.values)
    const request = {
      machine,
      programs: programs.map(({ file: program, dialect }) => ({ program, dialect })),
      recording: { name: recording.name, bytes: recording.bytes, interval: recording.interval },
    }
    /** @param {number[]} indices */
    function take(indices) {
      const among = indices.map((index) => programs[index].id)
      // Between those that a recording cannot tell apart its name may; one of none is compared with the program in sight, to say why.
      const alike = namesake(
        recording.name,
        programs.filter(({ id }) => among.includes(id)),
      )
      const program = among.length === 0 ? state.selected : among.length === 1 ? among[0] : alike
      recording.found = { program, among, of }
      recording.program = programFor(recording.chosen, recording, state.programs)
      recording.dialect = state.programs.find(({ id }) => id === recording.program)?.dialect
      page.paired(recording.id, recording.program)
    }
    return tried(
      async () => {
        const { found } = await engine.pair(request, stage)
        take(found)
      },
      (reason) => {
        take([])
        page.fail(say.work.notPaired(reason))
      },
    )
  }

  /** Compares a recording with its program; false where that was cancelled. @param {Recording} recording @param {string} motion */
  async function compare(recording, motion) {
    const program = state.programs.find(({ id }) => id === recording.program)
    if (!program) return false
    const { dialect } = program
    const stage = stageOf(program.id)
    stage('comparing', 0, recording.name)
    const machine = JSON.stringify(state.machine.values)
    const request = { program: program.file, machine, dialect, recording: recording.bytes, interval: recording.interval }
    return tried(
      async () => {
        const { report, refusal, columns } = await engine.compare(request, stage)
        // It may have been given another program meanwhile.
        if (recording.program === program.id && program.dialect === dialect && recording.interval === request.interval) {
          recording.match = { motion, report, refusal, columns }
          recording.failure = null
        }
      },
      (reason) => {
        recording.failure = motion
        page.fail(say.work.notCompared(recording.name, reason))
      },
    )
  }

  /** The recordings that are used, as they are asked about. */
  function collected() {
    return usable(state).flatMap(({ name, program: id, bytes: recording, interval }) => {
      const program = state.programs.find((candidate) => candidate.id === id)
      if (!program) return []
      return [{ name, program, request: { name, program: program.file, dialect: program.dialect, recording, interval } }]
    })
  }

  /** Diagnoses the machine; false where that was cancelled. */
  async function diagnose() {
    const stage = stageOf(null)
    stage('diagnosing', 0)
    const all = collected()
    if (all.length === 0) {
      state.diagnosing = false
      return true
    }
    const before = page.now()
    const [own, { motion }] = [evidence(state), state.machine]
    const runs = all.map(({ request }) => request)
    return tried(
      async () => {
        const { report, json, html, runs: columns } = await engine.diagnose({ machine: JSON.stringify(before.values), runs }, stage)
        state.diagnosing = false
        const diagnosed = all.map(({ name, program }, index) => ({ name, program, columns: columns[index] }))
        const motions = [motion, report?.values ? motionOf(JSON.stringify(report.values)) : motion]
        if (report) state.diagnosis = { report, json, html, runs: diagnosed, before, used: false, evidence: own, motions }
      },
      (reason) => {
        state.diagnosing = false
        page.fail(say.work.notDiagnosed(reason))
      },
    )
  }

  /** Calibrates the machine; false where that was cancelled. */
  async function calibrate() {
    const stage = stageOf(null)
    stage('calibrating', 0)
    const runs = collected().map(({ request }) => request)
    const before = page.now()
    return tried(
      async () => {
        const { report } = await engine.calibrate({ machine: JSON.stringify(before.values), runs }, stage)
        state.calibrating = false
        if (report) page.take({ report, before })
      },
      (reason) => {
        state.calibrating = false
        page.fail(say.work.notCalibrated(reason))
      },
    )
  }

  return work
}
