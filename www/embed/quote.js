// <truefeed-quote>: the cycle times and the price of a program, or of several that make a part, as an element of any page.
// Computed in a worker; nothing leaves the page.

import { Engine } from '../engine.js'
import { wholeModule } from '../module.js'
import { skeleton } from './answer.js'
import { QuoteError, bytesOf, refusalOf, refused, requestOf } from './request.js'
import { sheetOfQuote } from './sheet.js'

/** @import { Dialect, Machine, Program, Quote, Refusal, Tolerance } from "../../npm/index.d.ts" */

const MOST_BYTES = 64 * 1024 * 1024
/** The picture of the path, CSS pixels. */
const PICTURE_PX = [480, 300]

/** Who takes back what is computed, for something newer, has this long to do so again before a worker is started for it. */
const CALM_MS = 50

/** The word for the program's own tolerances. */
const PROGRAMMED = 'programmed'

export class QuoteElement extends HTMLElement {
  static observedAttributes = ['program-src', 'name', 'machine', 'tolerances', 'dialect', 'currency', 'picture']

  /** Makes the worker of an element; none for the engine's own way. @type {(() => Worker) | undefined} */
  static startWorker

  /** @type {Uint8Array | null} */
  #program = null
  #name = ''
  /** @type {Machine | null} */
  #machine = null
  /** @type {Tolerance[]} */
  #tolerances = []
  /** @type {Dialect | null} */
  #dialect = null
  /** Several programs that make a part; empty: the one program. @type {{name: string, program: Uint8Array}[]} */
  #programs = []
  /** @type {Quote[]} */
  #quotes = []
  /** The programs that `program-src` names, fetched when they are first needed. @type {Promise<Uint8Array[]> | null} */
  #source = null
  /** @type {AbortController | null} */
  #fetching = null
  /** @type {Engine | null} */
  #engine = null
  /** Counts what has been asked; an older answer counts for nothing. */
  #asked = 0
  #isScheduled = false
  /** Whether an answer is awaited. */
  #isBusy = false
  /** Ends a wait for calm. */
  #goOn = () => {}
  #parts

  constructor() {
    super()
    const root = this.attachShadow({ mode: 'open' })
    root.adoptedStyleSheets = [sheetOfQuote()]
    this.#parts = skeleton(root)
    this.#parts.input.addEventListener('change', () => this.#take(this.#parts.input.files ?? []))
    this.addEventListener('dragover', (event) => this.#over(event))
    this.addEventListener('dragleave', () => this.classList.remove('over'))
    this.addEventListener('drop', (event) => this.#drop(event))
  }

  connectedCallback() {
    this.#schedule()
  }

  disconnectedCallback() {
    this.cancel()
  }

  /** @param {string} attribute @param {string | null} before @param {string | null} value */
  attributeChangedCallback(attribute, before, value) {
    if (before === value) return
    if (attribute === 'program-src') {
      this.#fetching?.abort()
      this.#source = null
      this.#program = null
      this.#programs = []
    } else if (attribute === 'name') this.#name = value ?? ''
    else if (attribute === 'machine') this.#machine = machineFrom(value)
    else if (attribute === 'tolerances') this.#tolerances = tolerancesFrom(value)
    else if (attribute === 'dialect') this.#dialect = /** @type {Dialect | null} */ (value)
    this.#schedule()
  }

  /** @returns {Program | null} */
  get program() {
    return this.#program
  }
  set program(program) {
    this.#program = program === null ? null : bytesOf(program)
    this.#programs = []
    this.#schedule()
  }

  /** @returns {{name: string, program: Program}[]} */
  get programs() {
    return [...this.#programs]
  }
  set programs(programs) {
    this.#programs = programs.map(({ name, program }) => ({ name, program: bytesOf(program) }))
    this.#program = this.#programs[0]?.program ?? null
    this.#schedule()
  }

  get name() {
    return this.#name
  }
  set name(name) {
    this.#name = String(name)
    this.#schedule()
  }

  get machine() {
    return this.#machine
  }
  set machine(machine) {
    this.#machine = machine
    this.#schedule()
  }

  get tolerances() {
    return this.#tolerances
  }
  set tolerances(tolerances) {
    this.#tolerances = [...tolerances]
    this.#schedule()
  }

  get dialect() {
    return this.#dialect
  }
  set dialect(dialect) {
    this.#dialect = dialect
    this.#schedule()
  }

  get quote() {
    return this.#quotes[0] ?? null
  }

  /** The quotes of all programs, in their order. */
  get quotes() {
    return [...this.#quotes]
  }

  /** Computes now what is set. @returns {Promise<Quote>} */
  async compute() {
    const isHurried = this.#isBusy
    this.cancel()
    const own = this.#asked
    this.#quotes = []
    this.#isBusy = true
    this.#parts.busy()
    try {
      if (isHurried) await this.#calm()
      const answers = await this.#ask(own)
      this.#quotes = answers.map(({ quote }) => quote)
      this.#parts.show(this.#quotes, answers[0].labels, this.getAttribute('currency') ?? '', answers[0].picture)
      for (const detail of this.#quotes) this.dispatchEvent(new CustomEvent('quote', { detail, bubbles: true, composed: true }))
      return this.#quotes[0]
    } catch (error) {
      const refusal = refusalOf(error)
      // Of what was cancelled, only who asked for it hears.
      if (own === this.#asked) {
        this.#parts.fail(refusal)
        this.dispatchEvent(new CustomEvent('error', { detail: refusal }))
      }
      throw error
    } finally {
      if (own === this.#asked) this.#isBusy = false
    }
  }

  /** Waits until nothing newer has been asked for a moment, or something has. @returns {Promise<void>} */
  #calm() {
    return new Promise((done) => {
      const timer = setTimeout(done, CALM_MS)
      this.#goOn = () => {
        clearTimeout(timer)
        done()
      }
    })
  }

  /** Ends a computation. */
  cancel() {
    this.#asked += 1
    this.#isBusy = false
    this.#isScheduled = false
    this.#goOn()
    this.#engine?.cancel()
    this.#parts.rest()
  }

  /** The answer to what is set now, unless something newer is asked meanwhile. @param {number} own */
  async #ask(own) {
    const heed = () => {
      if (own !== this.#asked) throw refused('cancelled', 'The quote was cancelled, or a newer one was asked for.')
    }
    try {
      heed()
      const named = await this.#named()
      if (named.some(({ program }) => program.length > MOST_BYTES)) throw tooLarge()
      // What is wrong with the request is said before a module is fetched.
      const requests = named.map(({ name }) => requestOf(this.#machine, this.#tolerances, { name, dialect: this.#dialect }))
      const module = await wholeModule()
      heed()
      this.#engine ??= new Engine(module, QuoteElement.startWorker)
      const answers = []
      for (const [index, { program }] of named.entries()) {
        const picture = this.hasAttribute('picture') && index === 0 ? PICTURE_PX : null
        const { quote, refusal, ...rest } = await this.#engine.quote({ program, request: requests[index], picture }, (_, part) => {
          const all = (index + part) / named.length
          this.#parts.progress(all)
          this.dispatchEvent(new CustomEvent('progress', { detail: { part: all } }))
        })
        heed()
        if (!quote) throw new QuoteError(refusal ?? { kind: 'failed', message: 'There is no answer.', faults: [] })
        answers.push({ quote, ...rest })
      }
      return answers
    } catch (error) {
      heed()
      throw error instanceof QuoteError ? error : new QuoteError(refusalOf(error))
    }
  }

  /** What is to be quoted: what was given, or else what `program-src` names. @returns {Promise<{name: string, program: Uint8Array}[]>} */
  async #named() {
    const addresses = addressesOf(this.getAttribute('program-src'))
    const first = this.#name || nameOf(addresses[0])
    if (this.#programs.length > 0) return this.#programs
    if (this.#program) return [{ name: first, program: this.#program }]
    const programs = await this.#fetched(addresses)
    return programs.map((program, index) => ({ name: addresses.length === 1 ? first : nameOf(addresses[index]), program }))
  }

  /** @param {string[]} addresses */
  #fetched(addresses) {
    if (this.#source) return this.#source
    const { signal } = (this.#fetching = new AbortController())
    if (addresses.length === 0) return Promise.reject(refused('program', 'There is no program yet.'))
    const source = Promise.all(addresses.map((address) => fetched(address, signal)))
    this.#source = source
    // A failure is not kept: the next time it is tried again.
    source.catch(() => {
      if (this.#source === source) this.#source = null
    })
    return source
  }

  /** Computes once for all that is set in one go, as soon as there are program and machine. */
  #schedule() {
    if (this.#isScheduled || !this.isConnected) return
    this.#isScheduled = true
    queueMicrotask(() => {
      if (!this.#isScheduled) return
      this.#isScheduled = false
      if (!this.#program && !this.hasAttribute('program-src')) return
      if (this.#machine === null) return this.#parts.wait()
      // Its failure is told by the event.
      this.compute().catch(() => {})
    })
  }

  /** @param {Iterable<File>} chosen */
  async #take(chosen) {
    const files = [...chosen]
    if (files.length === 0) return
    this.#name = files[0].name
    if (files.some(({ size }) => size > MOST_BYTES)) {
      const refusal = refusalOf(tooLarge())
      this.#parts.fail(refusal)
      this.dispatchEvent(new CustomEvent('error', { detail: refusal }))
      return
    }
    const programs = await Promise.all(files.map(async (file) => ({ name: file.name, program: new Uint8Array(await file.arrayBuffer()) })))
    if (programs.length > 1) this.programs = programs
    else this.program = programs[0].program
  }

  /** @param {DragEvent} event */
  #over(event) {
    if (!event.dataTransfer?.types.includes('Files')) return
    event.preventDefault()
    this.classList.add('over')
  }

  /** @param {DragEvent} event */
  #drop(event) {
    this.classList.remove('over')
    if (!event.dataTransfer?.files.length) return
    event.preventDefault()
    this.#take(event.dataTransfer.files)
  }
}

const tooLarge = () => refused('size', `A program of more than ${MOST_BYTES / 1024 / 1024} MiB is too large.`)

/** JSON where it looks like it; else a preset's name or a machine file. @param {string | null} text @returns {Machine | null} */
function machineFrom(text) {
  if (text === null || !text.trimStart().startsWith('{')) return text
  try {
    return JSON.parse(text)
  } catch {
    // Rust refuses it with a reason.
    return text
  }
}

/** Millimetres, and a word for the program's own. @param {string | null} text @returns {Tolerance[]} */
function tolerancesFrom(text) {
  const words = (text ?? '').split(/[\s,;]+/).filter((word) => word !== '')
  return words.map((word) => (word === PROGRAMMED ? null : Number(word)))
}

/** The addresses of an attribute, set apart by blanks. @param {string | null} text */
const addressesOf = (text) => (text ?? '').split(/\s+/).filter((address) => address !== '')

/** @param {string} source @param {AbortSignal} signal */
async function fetched(source, signal) {
  try {
    const response = await fetch(new URL(source, document.baseURI), { signal })
    if (!response.ok) throw new Error(`${response.status} ${response.statusText}`.trim())
    if (Number(response.headers.get('Content-Length')) > MOST_BYTES) throw tooLarge()
    return new Uint8Array(await response.arrayBuffer())
  } catch (error) {
    if (error instanceof QuoteError) throw error
    if (signal.aborted) throw refused('cancelled', 'The quote was cancelled.')
    throw refused('program', `${source} cannot be fetched: ${error instanceof Error ? error.message : error}.`)
  }
}

/** The last part of an address. @param {string | null | undefined} address */
function nameOf(address) {
  return (
    (address ?? '')
      .replace(/[?#].*$/s, '')
      .split('/')
      .pop() ?? ''
  )
}

customElements.define('truefeed-quote', QuoteElement)
