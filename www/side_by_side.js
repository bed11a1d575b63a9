// Simulates a program for several columns by workers side by side. They share no memory, so that each reads the program for
// itself, which is a seventh of the work on one column. What a further worker leaves undone, as it died or could not be
// started, the first does afterwards.

/** @import { Engine, Listener, SimulateRequest, Stage } from "./engine.js" */
/** @import { Column } from "./types.js" */

/** @typedef {SimulateRequest & {program: Blob}} Request  of a file, for all columns or for some */

/** What all workers together may take, so that a machine of 4 GB has some left. */
const MOST_BYTES = 2e9
/** What a worker takes for each byte of the file; 7 to 15 were measured, less of larger files. */
const TIMES_THE_FILE = 12

/**
 * Does what `engine.simulate` does; the worker of that engine is the first.
 * @param {Engine} engine
 * @param {Request} request
 * @param {Listener} listener
 */
export async function simulate(engine, request, listener) {
  const [own, ...others] = dealt(request)
  const work = new Work(request, listener)
  /** @type {Engine[]} */
  const further = []
  /** @type {Promise<unknown> | undefined} */
  let beside
  const begin = () => {
    // The first has begun, so that the module is there which all of them take.
    beside ??= Promise.all(
      others.map(async (share) => {
        const other = engine.beside()
        further.push(other)
        await work.share(other, { ...share, runsOnly: true }).catch(() => {})
        // Its memory is free again when it ends, and not before.
        other.end()
      }),
    )
  }
  try {
    await work.share(engine, own, begin)
    await engine.until(Promise.resolve(beside))
    const left = part(request, (column) => !own.columns.includes(column) && !work.known.has(column))
    if (left.columns.length > 0) await work.share(engine, { ...left, runsOnly: true })
  } finally {
    for (const other of further) other.end()
  }
}

/** What each worker is to do: the first column is in sight, and is the first of the first one. @param {Request} request @returns {Request[]} */
function dealt(request) {
  const { columns, program } = request
  const affordable = Math.max(1, Math.floor(MOST_BYTES / (TIMES_THE_FILE * program.size)))
  const workers = Math.min(columns.length, navigator.hardwareConcurrency, affordable)
  return Array.from({ length: workers }, (_, worker) => part(request, (_, index) => index % workers === worker))
}

/** A request for some of the columns. @param {Request} request @param {(column: Column, index: number) => boolean} isOf @returns {Request} */
function part(request, isOf) {
  const labels = request.labels.filter((_, index) => isOf(request.columns[index], index))
  return { ...request, columns: request.columns.filter(isOf), labels }
}

/** What several workers do, told as if one did it. */
class Work {
  /** The columns that have come. @type {Set<Column>} */
  known = new Set()
  /** How many columns each worker has done, and which it is at. @type {Set<{done: number, label?: string}>} */
  #shares = new Set()
  #isTold = false
  /** How far the bar is, which never goes back. */
  #part = 0

  /** @param {Request} request @param {Listener} listener */
  constructor(request, listener) {
    this.labels = request.labels
    this.listener = listener
  }

  /** Has an engine do a share of it. @param {Engine} engine @param {Request} request @param {() => void} [begun] */
  async share(engine, request, begun) {
    const { known, listener } = this
    const share = { done: 0, label: /** @type {string | undefined} */ (undefined) }
    this.#shares.add(share)
    try {
      await engine.simulate(request, {
        stage: (stage, part, label) => {
          begun?.()
          // A worker that reads has done one part of one more than it has columns.
          share.done = Math.max(part * (request.columns.length + 1) - 1, 0)
          share.label = label
          this.#tell(stage)
        },
        // A worker that takes the place of a dead one says it again.
        program: (...all) => {
          if (!this.#isTold) listener.program(...all)
          this.#isTold = true
        },
        run: (column, run) => {
          // What nothing can be shown with yet is done again in the end.
          if (!this.#isTold) return
          known.add(column)
          listener.run(column, run)
        },
      })
    } finally {
      share.done = request.columns.filter((column) => known.has(column)).length
      share.label = undefined
    }
  }

  /** @param {Parameters<Stage>[0]} stage */
  #tell(stage) {
    const all = [...this.#shares]
    const done = all.reduce((sum, share) => sum + share.done, Number(this.#isTold))
    this.#part = Math.max(this.#part, done / (this.labels.length + 1))
    const labels = this.labels.filter((label) => all.some((share) => share.label === label))
    if (labels.length > 0) this.listener.stage('simulating', this.#part, labels.join(', '))
    else this.listener.stage(stage, this.#part)
  }
}
