// The package in Node: the module read from its file, quotes in the calling thread.

import { readFile } from 'node:fs/promises'
import init, { quoteProgram } from '../www/pkg/truefeed_whole.js'
import { QuoteError, bytesOf, refused, requestOf } from '../www/embed/request.js'

export { QuoteError }

/** @import { Machine, Program, Quote, QuoteOptions, Tolerance } from "./index.js" */

/** @type {Promise<unknown> | undefined} */
let started

/**
 * @param {Program} program
 * @param {Machine} machine
 * @param {Tolerance[]} tolerances
 * @param {QuoteOptions} options
 * @returns {Promise<Quote>}
 */
export async function quote(program, machine, tolerances = [], options = {}) {
  started ??= start()
  await started
  if (options.signal?.aborted) throw refused('cancelled', 'The quote was cancelled.')
  const request = requestOf(machine, tolerances, options)
  try {
    return quoteProgram(bytesOf(program), request, options.onProgress ?? (() => {}))
  } catch (refusal) {
    throw typeof refusal === 'string' ? new QuoteError(JSON.parse(refusal)) : refusal
  }
}

async function start() {
  await init({ module_or_path: await readFile(new URL('../www/pkg/truefeed_whole_bg.wasm', import.meta.url)) })
}
