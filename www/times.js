// Cycle times by tolerance and machine, without profiles: computed one after the other in a worker of their own when the
// page has nothing else to do, and kept as long as the program is.

import { motionOf } from './pkg/truefeed.js'
import { Ended } from './engine.js'

/** @import { Engine } from "./engine.js" */
/** @import { Column, Program, Values } from "./types.js" */

/** A machine that times are asked of. @typedef {{json: string, motion: string}} Asked */

/** What the simulation reads of a machine, and the machine as JSON; none where it has faults. @param {Values} values @returns {Asked | undefined} */
export function asked(values) {
  const json = JSON.stringify(values)
  const motion = motionOf(json)
  return motion === undefined ? undefined : { json, motion }
}

export class Times {
  /** @type {WeakMap<Program, Map<string, Map<Column, number>>>} */
  #kept = new WeakMap()
  #running = ''

  /** @param {Engine} engine */
  constructor(engine) {
    this.engine = engine
  }

  /** The cycle times (s) that are known. @param {Program} program @param {Asked} machine @returns {Map<Column, number>} */
  of(program, { motion }) {
    const own = this.#kept.get(program) ?? new Map()
    this.#kept.set(program, own)
    const key = `${program.dialect} ${motion}`
    const times = own.get(key) ?? new Map()
    own.set(key, times)
    return times
  }

  /**
   * Computes the first of what is wanted that is missing; `heard` after each time. What ran for something else ends.
   * False where nothing is missing.
   * @param {Program} program
   * @param {{machine: Asked, columns: Column[]}[]} wanted
   * @param {(failure?: string) => void} heard
   */
  compute(program, wanted, heard) {
    const lacking = wanted.map(({ machine, columns }) => {
      const times = this.of(program, machine)
      return { machine, times, columns: columns.filter((column) => !times.has(column)) }
    })
    const next = lacking.find(({ columns }) => columns.length > 0)
    if (!next) {
      this.stop()
      return false
    }
    const name = JSON.stringify([program.id, program.dialect, next.machine.json])
    // What runs will come to what is missing, or the next round does.
    if (this.#running === name) return true
    this.stop()
    this.#running = name
    this.#run(name, program, next, heard)
    return true
  }

  /** Ends what is running and gives back its memory. */
  stop() {
    this.#running = ''
    this.engine.end()
  }

  /** @param {string} name @param {Program} program @param {{machine: Asked, times: Map<Column, number>, columns: Column[]}} next @param {(failure?: string) => void} heard */
  async #run(name, { file, dialect }, { machine, times, columns }, heard) {
    try {
      await this.engine.timesOver({ program: file, machine: machine.json, dialect, columns }, (column, time) => {
        times.set(column, time)
        if (this.#running === name) heard()
      })
      if (this.#running !== name) return
      this.#running = ''
      heard()
    } catch (error) {
      if (error instanceof Ended && error.kind === 'cancelled') return
      this.#running = ''
      heard(error instanceof Error ? error.message : String(error))
    }
  }
}

/** From far apart to close together, so that a line is there soon and gets better. @template T @param {T[]} all @returns {T[]} */
export function coarseFirst(all) {
  const passes = [8, 4, 2, 1]
  const pass = (/** @type {number} */ index) => (index === all.length - 1 ? 0 : passes.findIndex((step) => index % step === 0))
  return all
    .map((one, index) => ({ one, at: pass(index) }))
    .sort((a, b) => a.at - b.at)
    .map(({ one }) => one)
}
