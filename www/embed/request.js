// What is asked for and refused, as it passes between a page, its worker and Node. What a request may say is Rust's affair.

/** @import { Dialect, Machine, Program, Refusal, Tolerance } from "../../npm/index.d.ts" */

/** A refused request. */
export class QuoteError extends Error {
  /** @param {Refusal} refusal */
  constructor({ kind, message, faults }) {
    super(message)
    this.name = 'QuoteError'
    this.kind = kind
    this.faults = faults
  }
}

/** @param {Refusal["kind"]} kind @param {string} message */
export const refused = (kind, message) => new QuoteError({ kind, message, faults: [] })

/** Anything thrown, as a refusal. @param {unknown} error @returns {Refusal} */
export function refusalOf(error) {
  if (error instanceof QuoteError) return { kind: error.kind, message: error.message, faults: error.faults }
  const message = error instanceof Error ? error.message : String(error)
  return { kind: 'failed', message, faults: [] }
}

/**
 * A request as the module reads it.
 * @param {Machine | null} machine
 * @param {Tolerance[]} tolerances
 * @param {{name?: string, dialect?: Dialect | null}} options
 */
export function requestOf(machine, tolerances, { name = '', dialect = null }) {
  if (machine === null || machine === undefined) throw refused('machine', 'Say which machine is meant.')
  try {
    return wellFormed(JSON.stringify({ machine, tolerances, name, dialect: dialect ?? undefined }))
  } catch (error) {
    throw refused('request', `The request cannot be written as JSON: ${error instanceof Error ? error.message : error}.`)
  }
}

/** JSON with U+FFFD for each half of a surrogate pair, as `TextEncoder` writes it: no text can hold one. @param {string} json */
const wellFormed = (json) => json.replace(/\\(?:ud[89a-f][\da-f]{2}|.)/g, (code) => (code.length > 2 ? '\ufffd' : code))

/** The bytes of a program. @param {Program} program */
export function bytesOf(program) {
  if (typeof program === 'string') return new TextEncoder().encode(program)
  if (program instanceof Uint8Array) return program
  throw refused('program', 'A program is a text or a Uint8Array.')
}
