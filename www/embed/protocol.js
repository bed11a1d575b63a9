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
const THEMED = ['accent', 'error', 'font', 'ground', 'line', 'muted', 'padding', 'radius', 'text'].map(
  (name) => `--truefeed-${name}`,
)

/** @typedef {string | number | null} Id */
/** @typedef {{type: string, id: Id, [key: string]: any}} Message */

const isText = (/** @type {unknown} */ value, /** @type {number} */ most) => typeof value === 'string' && value.length <= most
const isOptional = (/** @type {(value: unknown) => boolean} */ test) => (/** @type {unknown} */ value) =>
  value === undefined || value === null || test(value)

/** @typedef {Record<string, (value: any) => boolean>} Tests */

/** What each kind of message says, and the test of it. @type {Map<string, Tests>} */
const KINDS = new Map(
  Object.entries(/** @type {Record<string, Tests>} */ ({
    'load-program': {
      program: (value) => typeof value === 'string' || value instanceof Uint8Array || value instanceof ArrayBuffer,
      name: isOptional((value) => isText(value, LIMITS.nameCharacters)),
      dialect: isOptional((value) => isText(value, LIMITS.nameCharacters)),
    },
    'set-machine': { machine: (value) => typeof value === 'string' || isRecord(value) },
    'set-tolerances': {
      tolerances: (value) =>
        Array.isArray(value) &&
        value.length <= LIMITS.tolerances &&
        value.every((one) => one === null || (typeof one === 'number' && Number.isFinite(one))),
    },
    'set-theme': {
      theme: (value) =>
        isRecord(value) &&
        Object.entries(value).every(([key, text]) => THEMED.includes(key) && isText(text, LIMITS.themeCharacters)),
    },
    'get-quote': {},
    cancel: {},
  })),
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
  const tooLarge = sizeFault(data)
  if (tooLarge) return refuse('size', tooLarge)
  for (const [key, test] of Object.entries(kind)) {
    const value = Object.hasOwn(data, key) ? data[key] : undefined
    if (!test(value)) return refuse('request', `“${key}” of “${data.type}” is not what it should be.`)
  }
  return { message: /** @type {Message} */ (data) }
}

/** @param {Record<string, any>} data */
function sizeFault({ program, machine }) {
  // A letter takes three bytes at most for each of its units.
  const bytes = typeof program === 'string' ? program.length : (program?.byteLength ?? 0)
  if (bytes > LIMITS.programBytes) return `A program of more than ${LIMITS.programBytes} bytes is too large.`
  if (machine === undefined) return undefined
  let text
  try {
    text = JSON.stringify(machine) ?? ''
  } catch {
    return 'This machine cannot be written as JSON.'
  }
  return text.length > LIMITS.machineCharacters ? 'This machine is too large.' : undefined
}

/** @param {unknown} value @returns {value is Record<string, any>} */
function isRecord(value) {
  return typeof value === 'object' && value !== null && !Array.isArray(value) && !ArrayBuffer.isView(value)
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
