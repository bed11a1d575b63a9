// The frame of a portal on another origin: hears its messages, and answers to it alone.

import { confinedWorker } from '../confined.js'
import { LIMITS, VERSION, portalOf, readMessage } from './protocol.js'
import { QuoteElement } from './quote.js'
import { refusalOf } from './request.js'

/** @import { Id, Message } from "./protocol.js" */

QuoteElement.startWorker = confinedWorker

const portal = portalOf(location.search)
const element = /** @type {QuoteElement} */ (document.querySelector('truefeed-quote'))

/** @param {string} type @param {Id} id @param {object} [rest] */
function reply(type, id, rest = {}) {
  // The browser delivers it only if the parent is of this origin.
  if (portal) window.parent.postMessage({ truefeed: VERSION, id, type, ...rest }, portal)
}

/** The id of the get-quote in work; null while what is computed was not asked for by one. @type {Id} */
let current = null

/** @param {Message} message */
async function answer(message) {
  const { id, type } = message
  if (type === 'get-quote') {
    current = id
    try {
      const quote = await element.compute()
      reply('quote', id, { quote })
    } finally {
      if (current === id) current = null
    }
    return
  }
  if (type === 'load-program') {
    const { program, name, dialect } = message
    element.name = name ?? ''
    element.dialect = dialect ?? null
    element.program = program instanceof ArrayBuffer ? new Uint8Array(program) : program
  } else if (type === 'set-machine') element.machine = message.machine
  else if (type === 'set-tolerances') element.tolerances = message.tolerances
  else if (type === 'set-theme') {
    for (const [name, value] of Object.entries(message.theme)) element.style.setProperty(name, value)
  } else element.cancel()
  reply('ready', id)
}

/** @param {MessageEvent} event */
function hear({ data, origin, source }) {
  if (origin !== portal || source !== window.parent) return
  const read = readMessage(data)
  if (!read) return
  if ('refusal' in read) return reply('error', read.id, { error: read.refusal })
  const { message } = read
  answer(message).catch((error) => reply('error', message.id, { error: refusalOf(error) }))
}

/** A message that the browser cannot read here, such as one of too many objects in each other: its id is not known. @param {MessageEvent} event */
function hearUnreadable({ origin, source }) {
  if (origin !== portal || source !== window.parent) return
  reply('error', null, { error: { kind: 'request', message: 'The browser could not read this message.', faults: [] } })
}

/** @param {string} type @param {(detail: any) => void} listener */
function hearElement(type, listener) {
  element.addEventListener(type, (event) => listener(/** @type {CustomEvent} */ (event).detail))
}

if (portal && window.parent !== window) {
  window.addEventListener('message', hear)
  window.addEventListener('messageerror', hearUnreadable)
  hearElement('progress', (detail) => reply('progress', current, detail))
  // What get-quote asked for goes with its id; these come by themselves, of what was set or of a program the user chose.
  hearElement('quote', (quote) => current === null && reply('quote', null, { quote }))
  hearElement('error', (error) => current === null && reply('error', null, { error }))
  const { height } = element.getBoundingClientRect()
  new ResizeObserver(() => reply('resize', null, { height: document.documentElement.offsetHeight })).observe(element)
  reply('ready', null, { limits: LIMITS, height })
} else {
  element.remove()
  const refusal = /** @type {HTMLElement} */ (document.getElementById('refusal'))
  refusal.hidden = false
}
