// Simulates in the background: one request in, messages out, columns transferred.

import init, { Job } from './pkg/truefeed.js'

/** @import { Columns, Steps } from "./types.js" */

self.onmessage = async ({ data: { module, program, machine, columns, labels } }) => {
  try {
    const of = columns.length + 1
    stage('Reading the program', 0, of)
    await init({ module_or_path: module })
    const job = new Job(program, machine)
    const steps = plain(job.steps(), ['end', 'feedrate', 'rapid', 'line'])
    const held = job.tolerances()
    post({ type: 'program', summary: job.summary(), steps, held }, Object.values(steps))
    for (const [index, column] of columns.entries()) {
      if (column === null && held.length === 0) continue
      const progress = (/** @type {number} */ part) => stage(`Simulating ${labels[index]}`, index + 1 + part, of)
      progress(0)
      const run = job.simulate(column ?? undefined, progress)
      const curve = plain(run.columns, ['distance', 'feedrate', 'time', 'corner', 'arc'])
      post({ type: 'run', column, summary: run.summary.runs[0], columns: curve }, Object.values(curve))
      run.free()
    }
    job.free()
    post({ type: 'done' }, [])
  } catch (error) {
    const message = error instanceof Error ? error.message : String(error)
    post({ type: 'failure', message, bug: error instanceof WebAssembly.RuntimeError }, [])
  }
}

/** @param {string} text @param {number} done @param {number} of */
function stage(text, done, of) {
  post({ type: 'stage', text, part: done / of }, [])
}

/**
 * The named columns of a handle of the module as a plain object; the handle is given back.
 * @template {{free(): void}} H
 * @template {keyof H} K
 * @param {H} handle
 * @param {K[]} names
 * @returns {Pick<H, K>}
 */
function plain(handle, names) {
  const columns = /** @type {Pick<H, K>} */ (Object.fromEntries(names.map((name) => [name, handle[name]])))
  handle.free()
  return columns
}

/** @param {object} message @param {ArrayBufferView[]} columns */
function post(message, columns) {
  self.postMessage(message, { transfer: columns.map((column) => column.buffer) })
}
