// The package in a browser: quotes in a worker, one after the other.

import { Ended, Engine } from '../www/engine.js'
import { wholeModule } from '../www/module.js'
import { QuoteError, bytesOf, refused, requestOf } from '../www/embed/request.js'

export { QuoteError }

/** @import { Machine, Program, Quote, QuoteOptions, Tolerance } from "./index.js" */

/** @type {Engine | undefined} */
let engine
/** @type {Promise<unknown>} */
let last = Promise.resolve()

/**
 * @param {Program} program
 * @param {Machine} machine
 * @param {Tolerance[]} tolerances
 * @param {QuoteOptions} options
 * @returns {Promise<Quote>}
 */
export function quote(program, machine, tolerances = [], options = {}) {
  const result = last.then(() => compute(program, machine, tolerances, options))
  last = result.catch(() => {})
  return result
}

/** @type {typeof quote} */
async function compute(program, machine, tolerances = [], options = {}) {
  const { signal, onProgress = () => {} } = options
  const cancelled = () => refused('cancelled', 'The quote was cancelled.')
  const question = { program: bytesOf(program), request: requestOf(machine, tolerances, options) }
  engine ??= new Engine(await wholeModule())
  if (signal?.aborted) throw cancelled()
  const cancel = () => engine?.cancel()
  signal?.addEventListener('abort', cancel)
  try {
    const { quote, refusal } = await engine.quote(question, (_, part) => onProgress(part))
    if (quote) return quote
    throw new QuoteError(refusal ?? { kind: 'failed', message: 'There is no answer.', faults: [] })
  } catch (error) {
    if (!(error instanceof Ended)) throw error
    throw error.kind === 'cancelled' ? cancelled() : refused('failed', error.message)
  } finally {
    signal?.removeEventListener('abort', cancel)
  }
}
