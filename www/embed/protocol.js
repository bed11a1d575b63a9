// The messages between a portal and the frame: what is taken, and what is refused before anything else sees it.
//
// A message is {truefeed: 1, id, type, …}. It is read by its own keys only, each of which must be known and of the right kind;
// everything about machines and tolerances beyond their size is for Rust to judge.

/** @import { Refusal } from "../../npm/index.d.ts" */

export const VERSION = 1

/** What is refused beyond these, by name; sent along when the frame is ready. */
export const LIMITS = Object.freeze({
  programBytes: 64 * 1024 * 1024,
  machineCharacters: 64 * 1024,
  tolerances: 32,
  nameCharacters: 255,
  idCharacters: 100,
  themeCharacters: 200,
})

/** What may be themed. */
const THEMED = ['accent', 'error', 'font', 'ground', 'line', 'muted', 'padding', 'radius', 'text'].map((name) => `--truefeed-${name}`)

/** @typedef {string | number | null} Id */
/** @typedef {{type: string, id: Id, [key: string]: any}} Message */

const isText = (/** @type {unknown} */ value, /** @type {number} */ most) => typeof value === 'string' && value.length <= most
const isOptional = (/** @type {(value: unknown) => boolean} */ test) => (/** @type {unknown} */ value) => value === undefined || value === null || test(value)

/** What a key must be, in words, and the test of it. @typedef {Record<string, [string, (value: any) => boolean]>} Tests */

const SHORT_TEXT = `a text of up to ${LIMITS.nameCharacters} characters`

/** What each kind of message says. @type {Map<string, Tests>} */
const KINDS = new Map(
  Object.entries(
    /** @type {Record<string, Tests>} */ ({
      'load-program': {
        program: ['a text, a Uint8Array or an ArrayBuffer', (value) => typeof value === 'string' || value instanceof Uint8Array || value instanceof ArrayBuffer],
        name: [SHORT_TEXT, isOptional((value) => isText(value, LIMITS.nameCharacters))],
        dialect: [SHORT_TEXT, isOptional((value) => isText(value, LIMITS.nameCharacters))],
      },
      'set-machine': {
        machine: [
          'a text, or a plain object of plain objects, lists, texts, finite numbers, true, false and null',
          (value) => typeof value === 'string' || (isRecord(value) && partsOf(value).every(isJson)),
        ],
      },
      'set-tolerances': {
        tolerances: [
          `a list of up to ${LIMITS.tolerances} numbers in mm, or null for the program’s own`,
          (value) => Array.isArray(value) && value.length <= LIMITS.tolerances && value.every((one) => one === null || (typeof one === 'number' && Number.isFinite(one))),
        ],
      },
      'set-theme': {
        theme: [
          `an object with texts of up to ${LIMITS.themeCharacters} characters for any of ${THEMED.join(', ')}`,
          (value) => isRecord(value) && Object.entries(value).every(([key, text]) => THEMED.includes(key) && isText(text, LIMITS.themeCharacters)),
        ],
      },
      'get-quote': {},
      cancel: {},
    }),
  ),
)

/**
 * A message, or why it is refused; undefined for what is none of ours, such as messages of other scripts.
 * @param {unknown} data
 * @returns {{message: Message} | {id: Id, refusal: Refusal} | undefined}
 */
export function readMessage(data) {
  if (!isRecord(data) || !Object.hasOwn(data, 'truefeed')) return undefined
  const id = isId(data.id) ? data.id : null
  const refuse = (/** @type {Refusal["kind"]} */ kind, /** @type {string} */ message) => ({
    id,
    refusal: { kind, message, faults: [] },
  })
  if (data.truefeed !== VERSION) return refuse('version', `This frame speaks version ${VERSION} of the messages.`)
  if (!Object.hasOwn(data, 'id') || !isId(data.id)) return refuse('request', 'A message needs an id, a number or a short text.')
  const kind = typeof data.type === 'string' && Object.hasOwn(data, 'type') ? KINDS.get(data.type) : undefined
  if (!kind) return refuse('type', `There is no such type of message; there are ${[...KINDS.keys()].join(', ')}.`)
  const unknown = Object.keys(data).find((key) => !['truefeed', 'id', 'type'].includes(key) && !Object.hasOwn(kind, key))
  if (unknown !== undefined) return refuse('request', `“${data.type}” has no “${unknown.slice(0, 40)}”.`)
  for (const [key, [wanted, test]] of Object.entries(kind)) {
    const value = Object.hasOwn(data, key) ? data[key] : undefined
    if (!test(value)) return refuse('request', `“${key}” of “${data.type}” must be ${wanted}.`)
  }
  const tooLarge = sizeFault(data)
  if (tooLarge) return refuse('size', tooLarge)
  return { message: /** @type {Message} */ (data) }
}

/** @param {Record<string, any>} data */
function sizeFault({ program, machine }) {
  // A letter takes three bytes at most for each of its units.
  const bytes = typeof program === 'string' ? program.length : (program?.byteLength ?? 0)
  if (bytes > LIMITS.programBytes) return `A program of more than ${LIMITS.programBytes} bytes is too large.`
  if (machine === undefined) return undefined
  const isSmall = partsOf(machine).length <= LIMITS.machineCharacters && jsonLength(machine) <= LIMITS.machineCharacters
  return isSmall ? undefined : `A machine of more than ${LIMITS.machineCharacters} characters is too large.`
}

/** How long a value is as JSON; without end where its parts are in each other deeper than a browser writes. @param {unknown} value */
function jsonLength(value) {
  try {
    return JSON.stringify(value).length
  } catch {
    return Infinity
  }
}

/** What a message brings has the prototypes of the frame: dates, maps, regular expressions and the like are no records. @param {unknown} value @returns {value is Record<string, any>} */
function isRecord(value) {
  return typeof value === 'object' && value !== null && Object.getPrototypeOf(value) === Object.prototype
}

/**
 * A value with all that is in it. Parts that hold each other have no end, so those beyond the limit of a machine, each of which
 * takes a character at least, are left out but for the first.
 * @param {unknown} whole
 */
function partsOf(whole) {
  const parts = [whole]
  for (let at = 0; at < parts.length && parts.length <= LIMITS.machineCharacters; at += 1) {
    const value = parts[at]
    if (!Array.isArray(value) && !isRecord(value)) continue
    for (const part of Array.isArray(value) ? value : Object.values(value)) {
      parts.push(part)
      if (parts.length > LIMITS.machineCharacters) break
    }
  }
  return parts
}

/** Whether JSON has a word for a value, parts aside. @param {unknown} value */
function isJson(value) {
  return value === null || ['string', 'boolean', 'undefined'].includes(typeof value) || Number.isFinite(value) || Array.isArray(value) || isRecord(value)
}

/** @param {unknown} value */
function isId(value) {
  return Number.isFinite(value) || isText(value, LIMITS.idCharacters)
}

/** The origin that an address names as the portal's, if it is one. @param {string} search */
export function portalOf(search) {
  const given = new URLSearchParams(search).getAll('origin')
  if (given.length !== 1 || !URL.canParse(given[0])) return undefined
  const { origin, protocol } = new URL(given[0])
  return origin === given[0] && /^https?:$/.test(protocol) ? origin : undefined
}
