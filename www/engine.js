// Runs simulations in a worker, one at a time. Cancelling ends the worker; the next run starts a fresh one.

/** @import { Column, Held, ProgramSummary, Steps, Run } from "./types.js" */

/**
 * @typedef {object} Request
 * @property {Uint8Array} program
 * @property {string} machine  JSON
 * @property {string | null} dialect  null: the one the program shows
 * @property {Column[]} columns
 * @property {string[]} labels  of the columns
 */

/**
 * @typedef {object} Listener
 * @property {(text: string, part: number) => void} stage
 * @property {(summary: ProgramSummary, steps: Steps, held: Held[]) => void} program
 * @property {(column: Column, run: Run) => void} run
 */

/** Why a run ended early. */
export class Ended extends Error {
  /** @param {"cancelled" | "failed"} kind @param {string} message */
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

  /** @param {WebAssembly.Module} module */
  constructor(module) {
    this.module = module
  }

  /** Simulates a program; the listener hears of each part. @param {Request} request @param {Listener} listener */
  async simulate(request, listener) {
    this.cancel()
    this.#worker ??= new Worker(new URL('worker.js', import.meta.url), { type: 'module' })
    const worker = this.#worker
    await new Promise((resolve, reject) => {
      this.#reject = reject
      worker.onerror = (event) => this.#end('failed', event.message ?? 'the worker could not be started')
      worker.onmessage = ({ data }) => {
        if (data.type === 'stage') listener.stage(data.text, data.part)
        else if (data.type === 'program') listener.program(data.summary, data.steps, data.held)
        else if (data.type === 'run') listener.run(data.column, { summary: data.summary, columns: data.columns })
        else if (data.type === 'failure') this.#end('failed', data.message)
        else {
          this.#reject = null
          resolve(undefined)
        }
      }
      worker.postMessage({ module: this.module, ...request })
    })
  }

  /** Ends what is running, if anything is. */
  cancel() {
    if (this.#reject) this.#end('cancelled', 'cancelled')
  }

  /** @param {"cancelled" | "failed"} kind @param {string} message */
  #end(kind, message) {
    this.#worker?.terminate()
    this.#worker = null
    this.#reject?.(new Ended(kind, message))
    this.#reject = null
  }
}
