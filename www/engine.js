// Runs simulations, comparisons, calibrations and diagnoses in a worker, one at a time. Cancelling ends the worker; the next run
// starts a fresh one. A worker begins with the module of the first visit; what that one leaves out is fetched when it is first
// asked for, or when a program turns out to need it, and then a worker with the whole module takes its place, which does all. A
// worker that dies at work is replaced, and the work begun again, once: what kills a second one is in the work.

/** @import { StageName } from "./texts.js" */
/** @import { CalibrationReport, DiagnosedRun, DiagnosisReport, Column, ComparisonReport, CutResult, Held, MatchedColumns, ProgramSummary, Refusal, RevisionsReport, Steps, Run, Trail } from "./types.js" */

/**
 * @typedef {object} SimulateRequest
 * @property {Blob | Uint8Array} program  a file is read piece by piece
 * @property {string} machine  JSON
 * @property {string | null} dialect  null: the one the program shows
 * @property {Column[]} columns
 * @property {string[]} labels  of the columns
 * @property {boolean} [runsOnly]  what the program says is told already
 */

/** @typedef {{program: Blob | Uint8Array, machine: string, dialect: string | null, recording: Uint8Array, interval: number | null}} CompareRequest */
/** Both revisions, the earlier first. @typedef {{program: Blob | Uint8Array, machine: string, dialect: string | null, tolerance: Column}[]} ReviseRequest */
/** @typedef {{machine: string, runs: {name: string, program: Blob | Uint8Array, dialect: string | null, recording: Uint8Array, interval: number | null}[]}} CalibrateRequest */
/** @typedef {{machine: string, programs: {program: Blob | Uint8Array, dialect: string | null}[], recording: {name: string, bytes: Uint8Array, interval: number | null}}} PairRequest */
/** @typedef {{program: Blob | Uint8Array, machine: string, dialect: string | null, tolerance: Column, job: string}} CutRequest */
/** @typedef {{program: Blob | Uint8Array, dialect: string | null, machines: string[]}} TimesRequest */
/** @typedef {{program: Blob | Uint8Array, machine: string, dialect: string | null, columns: Column[]}} TimesOverRequest */
/** @typedef {{program: Blob | Uint8Array, request: string, picture?: number[] | null}} QuoteRequest  the request as JSON; `picture`: width and height of one of the path, CSS pixels */
/** @typedef {(stage: StageName, part: number, name?: string) => void} Stage */

/**
 * @typedef {object} Listener
 * @property {Stage} stage
 * @property {(summary: ProgramSummary, steps: Steps, held: Held[], trail: Trail) => void} program
 * @property {(column: Column, run: Run) => void} run
 */

/** @import { Compiled } from "./module.js" */

/** What the module of the first visit leaves out: what reads a recording, a cutting job or the request of another page. */
const LATER = new Set(['pair', 'compare', 'revise', 'calibrate', 'diagnose', 'cycleTimes', 'cut', 'quote'])

/** A program of this size is sooner computed when the whole module, which is quicker, has come, and by several workers. */
export const LARGE_BYTES = 1_500_000

/** @param {{program?: Blob | Uint8Array}} request */
const sizeOf = ({ program }) => (program instanceof Blob ? program.size : (program?.length ?? 0))

/** Without a network what is here does as well. @param {unknown} error */
export function unlessCancelled(error) {
  if (error instanceof Ended && error.kind === 'cancelled') throw error
}

/** Why a run ended early. */
export class Ended extends Error {
  /** @param {"cancelled" | "died" | "failed" | "left"} kind @param {string} message */
  constructor(kind, message) {
    super(message)
    this.kind = kind
  }
}

export class Engine {
  /** @type {Worker | null} */
  #worker = null
  /** @type {((reason: Ended) => void) | null} */
  #reject = null
  /** Whether the worker holds another module than the next one will. */
  #isOutdated = false
  /** Whether work that kills a worker is begun again. */
  #isPatient = true

  /** What the worker holds, or the next one will. @type {Compiled} */
  #module

  /**
   * @param {Compiled} module
   * @param {() => Worker} start  makes the worker
   * @param {() => Promise<Compiled>} whole  fetches the whole module
   */
  constructor(
    module,
    start = () => new Worker(new URL('worker.js', import.meta.url), { type: 'module' }),
    whole = () => Promise.reject(new Error('the module holds only what the first visit needs')),
  ) {
    this.#module = module
    this.start = start
    this.whole = whole
  }

  /** Simulates a program; the listener hears of each part. @param {SimulateRequest} request @param {Listener} listener */
  async simulate(request, listener) {
    await this.#run('simulate', request, (data) => {
      if (data.type === 'stage') listener.stage(data.stage, data.part, data.name)
      else if (data.type === 'program') listener.program(data.summary, data.steps, data.held, data.trail)
      else listener.run(data.column, { summary: data.summary, columns: data.columns, note: data.note, placesInInches: data.placesInInches })
    })
  }

  /**
   * Compares a recording with a program.
   * @param {CompareRequest} request
   * @param {Stage} stage
   * @returns {Promise<{report?: ComparisonReport, refusal?: Refusal, columns: MatchedColumns}>}
   */
  compare(request, stage) {
    return this.#result('compare', request, stage)
  }

  /** Finds the programs that a recording can be of, by their places. @param {PairRequest} request @param {Stage} stage @returns {Promise<{found: number[]}>} */
  pair(request, stage) {
    return this.#result('pair', request, stage)
  }

  /** Says where two revisions of a program differ. @param {ReviseRequest} request @param {Stage} stage @returns {Promise<{report: RevisionsReport, columns: {distance: Float64Array, later: Float64Array}}>} */
  revise(request, stage) {
    return this.#result('revise', request, stage)
  }

  /**
   * Calibrates a machine; undefined where no run can be compared.
   * @param {CalibrateRequest} request
   * @param {Stage} stage
   * @returns {Promise<{report?: CalibrationReport}>}
   */
  calibrate(request, stage) {
    return this.#result('calibrate', request, stage)
  }

  /**
   * Says what was left out of a machine; undefined where no run can be compared.
   * @param {CalibrateRequest} request
   * @param {Stage} stage
   * @returns {Promise<{report?: DiagnosisReport, json: string, html: string, runs: DiagnosedRun["columns"][]}>}
   */
  diagnose(request, stage) {
    return this.#result('diagnose', request, stage)
  }

  /** Cycle times (s) of a program on several machines. @param {TimesRequest} request @returns {Promise<{times: number[]}>} */
  cycleTimes(request) {
    return this.#result('cycleTimes', request, () => {})
  }

  /** Cycle times (s) of a program by tolerance, one after the other. @param {TimesOverRequest} request @param {(column: Column, time: number) => void} heard */
  async timesOver(request, heard) {
    await this.#run('timesOver', request, ({ column, time }) => heard(column, time))
  }

  /** Cuts the stock of a job with a program. @param {CutRequest} request @param {Stage} stage @returns {Promise<CutResult>} */
  cut(request, stage) {
    return this.#result('cut', request, stage)
  }

  /**
   * Quotes a program, or says why the request is refused.
   * @param {QuoteRequest} request
   * @param {Stage} stage
   * @returns {Promise<{quote?: import("../npm/index.d.ts").Quote, refusal?: import("../npm/index.d.ts").Refusal, labels: string[], picture?: string}>}
   */
  quote(request, stage) {
    return this.#result('quote', request, stage)
  }

  /** Runs what gives one result. @param {string} verb @param {object} request @param {Stage} stage @returns {Promise<any>} */
  async #result(verb, request, stage) {
    let result
    await this.#run(verb, request, (data) => {
      if (data.type === 'stage') stage(data.stage, data.part, data.name)
      else result = data
    })
    return result
  }

  /** @param {string} verb @param {object} request @param {(data: any) => void} hear */
  async #run(verb, request, hear) {
    this.cancel()
    if (!this.#module.isWhole) {
      if (LATER.has(verb)) await this.#load()
      else if (LARGE_BYTES < sizeOf(request)) await this.#load().catch(unlessCancelled)
    }
    try {
      await this.#attemptTwice(verb, request, hear)
    } catch (error) {
      if (!(error instanceof Ended) || error.kind !== 'left') throw error
      await this.#load()
      await this.#attemptTwice(verb, request, hear)
    }
  }

  /** @param {string} verb @param {object} request @param {(data: any) => void} hear */
  async #attemptTwice(verb, request, hear) {
    try {
      await this.#attempt(verb, request, hear)
    } catch (error) {
      if (!(error instanceof Ended) || error.kind !== 'died' || !this.#isPatient) throw error
      await this.#attempt(verb, request, hear)
    }
  }

  /** @param {string} verb @param {object} request @param {(data: any) => void} hear */
  async #attempt(verb, request, hear) {
    this.#worker ??= this.#started()
    const worker = this.#worker
    await new Promise((resolve, reject) => {
      this.#reject = reject
      worker.onmessage = ({ data }) => {
        if (data.type === 'failure') this.#end(data.left ? 'left' : data.bug ? 'died' : 'failed', data.message)
        else if (data.type === 'done') {
          // Who hears of a request holds what it gave: nobody does once it is done.
          worker.onmessage = null
          this.#settle()
          resolve(undefined)
        } else hear(data)
      }
      worker.postMessage({ ...this.#module, language: navigator.language, verb, request })
    })
  }

  /** A worker whose death is noticed, whatever it does. */
  #started() {
    const worker = this.start()
    worker.onerror = (event) => this.#end('died', event.message ?? '')
    return worker
  }

  /** Gets the whole module, which ends a worker that holds a part of it. Cancelling ends the wait, not the download. */
  async #load() {
    this.prefer(await this.until(this.whole()))
  }

  /**
   * Waits for what is not done by the worker here as if it was: cancelling ends the wait.
   * @template T
   * @param {Promise<T>} coming
   * @returns {Promise<T>}
   */
  until(coming) {
    return new Promise((resolve, reject) => {
      this.#reject = reject
      coming.then(
        (come) => {
          if (this.#reject === reject) this.#settle()
          resolve(come)
        },
        (error) => {
          if (this.#reject === reject) this.#end('failed', error.message)
        },
      )
    })
  }

  /** Another with the same module and a worker of its own, which does not try twice: what it fails at can be done here. */
  beside() {
    const other = new Engine(this.#module, this.start, this.whole)
    other.#isPatient = false
    return other
  }

  /** Makes a worker ready for the next request. */
  warm() {
    if (this.#worker) return
    this.#worker = this.#started()
    this.#worker.postMessage({ ...this.#module, language: navigator.language })
  }

  /** Computes with another module from the next request on. @param {Compiled} module */
  prefer(module) {
    if (this.#module.isWhole || !module.isWhole) return
    this.#module = module
    if (this.#reject) this.#isOutdated = true
    else this.#replace()
  }

  /** Is ready for the next request. */
  #settle() {
    this.#reject = null
    if (this.#isOutdated) this.#replace()
  }

  /** Ends a worker that does nothing, for one with the module of now. */
  #replace() {
    this.#isOutdated = false
    this.#worker?.terminate()
    this.#worker = null
  }

  /** Ends what is running, if anything is. */
  cancel() {
    if (this.#reject) this.#end('cancelled', 'cancelled')
  }

  /** Ends the worker, whatever it does, and gives its memory back. */
  end() {
    this.#end('cancelled', 'cancelled')
  }

  /** @param {Ended["kind"]} kind @param {string} message */
  #end(kind, message) {
    this.#replace()
    this.#reject?.(new Ended(kind, message))
    this.#reject = null
  }
}
