// <truefeed-quote>: the cycle times of a program as an element of any page. Computed in a worker; nothing leaves the page.

import { make } from '../dom.js'
import { Engine } from '../engine.js'
import * as show from '../format.js'
import { say } from '../texts_later.js'
import { wholeModule } from './module.js'
import { QuoteError, bytesOf, refusalOf, refused, requestOf } from './request.js'
import { sheetOfQuote } from './sheet.js'

/** @import { Dialect, Machine, Program, Quote, Refusal, Tolerance } from "../../npm/index.d.ts" */

const MOST_BYTES = 64 * 1024 * 1024
const MOST_REMARKS = 20

/** Who takes back what is computed, for something newer, has this long to do so again before a worker is started for it. */
const CALM_MS = 50

/** The word for the program's own tolerances. */
const PROGRAMMED = 'programmed'

export class QuoteElement extends HTMLElement {
  static observedAttributes = ['program-src', 'name', 'machine', 'tolerances', 'dialect']

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
  /** @type {Quote | null} */
  #quote = null
  /** The program that `program-src` names, fetched when it is first needed. @type {Promise<Uint8Array> | null} */
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
    this.#parts.input.addEventListener('change', () => this.#take(this.#parts.input.files?.[0]))
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
    } else if (attribute === 'name') this.#name = value ?? ''
    else if (attribute === 'machine') this.#machine = machineFrom(value)
    else if (attribute === 'tolerances') this.#tolerances = tolerancesFrom(value)
    else this.#dialect = /** @type {Dialect | null} */ (value)
    this.#schedule()
  }

  /** @returns {Program | null} */
  get program() {
    return this.#program
  }
  set program(program) {
    this.#program = program === null ? null : bytesOf(program)
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
    return this.#quote
  }

  /** Computes now what is set. @returns {Promise<Quote>} */
  async compute() {
    const isHurried = this.#isBusy
    this.cancel()
    const own = this.#asked
    this.#quote = null
    this.#isBusy = true
    this.#parts.busy()
    try {
      if (isHurried) await this.#calm()
      const { quote, labels } = await this.#ask(own)
      this.#quote = quote
      this.#parts.show(quote, labels)
      this.dispatchEvent(new CustomEvent('quote', { detail: quote, bubbles: true, composed: true }))
      return quote
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
      const name = this.#name || nameOf(this.getAttribute('program-src'))
      const request = requestOf(this.#machine, this.#tolerances, { name, dialect: this.#dialect })
      const program = this.#program ?? (await this.#fetched())
      if (program.length > MOST_BYTES) throw tooLarge()
      const module = await wholeModule()
      heed()
      this.#engine ??= new Engine(module, QuoteElement.startWorker)
      const { quote, refusal, labels } = await this.#engine.quote({ program, request }, (_, part) => {
        this.#parts.progress(part)
        this.dispatchEvent(new CustomEvent('progress', { detail: { part } }))
      })
      heed()
      if (!quote) throw new QuoteError(refusal ?? { kind: 'failed', message: 'There is no answer.', faults: [] })
      return { quote, labels }
    } catch (error) {
      heed()
      throw error instanceof QuoteError ? error : new QuoteError(refusalOf(error))
    }
  }

  #fetched() {
    if (this.#source) return this.#source
    const source = this.#fetch()
    this.#source = source
    // A failure is not kept: the next time it is tried again.
    source.catch(() => {
      if (this.#source === source) this.#source = null
    })
    return source
  }

  async #fetch() {
    const source = this.getAttribute('program-src')
    if (!source) throw refused('program', 'There is no program yet.')
    const { signal } = (this.#fetching = new AbortController())
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

  /** @param {File | undefined} file */
  async #take(file) {
    if (!file) return
    this.#name = file.name
    if (file.size > MOST_BYTES) {
      const refusal = refusalOf(tooLarge())
      this.#parts.fail(refusal)
      this.dispatchEvent(new CustomEvent('error', { detail: refusal }))
      return
    }
    this.program = new Uint8Array(await file.arrayBuffer())
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
    this.#take(event.dataTransfer.files[0])
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

/** The last part of an address. @param {string | null} address */
function nameOf(address) {
  return (address ?? '').replace(/[?#].*$/s, '').split('/').pop() ?? ''
}

/** What stands in the element, and how it changes. @param {ShadowRoot} root */
function skeleton(root) {
  const input = make('input', { type: 'file', ariaLabel: say.embed.choose })
  const choice = make('span', {}, say.embed.choose)
  const title = make('p', { className: 'title' }, say.common.cycleTime)
  const about = make('p', { className: 'about' }, say.embed.drop)
  const bar = make('progress', { max: 1, hidden: true, ariaLabel: say.embed.simulating })
  const error = make('p', { className: 'error', hidden: true, role: 'alert' })
  const answer = make('div', { ariaLive: 'polite' })
  for (const [part, element] of Object.entries({ title, about, error, answer })) element.setAttribute('part', part)
  root.append(make('div', { className: 'head' }, title, make('label', {}, choice, input)), about, bar, error, answer)

  const rest = () => {
    bar.hidden = true
    error.hidden = true
    answer.classList.remove('stale')
  }
  return {
    input,
    rest,
    busy() {
      rest()
      bar.hidden = false
      bar.removeAttribute('value')
      answer.classList.add('stale')
    },
    wait() {
      rest()
      about.textContent = say.embed.noMachine
    },
    /** @param {number} part */
    progress(part) {
      bar.value = part
    },
    /** @param {Refusal} refusal */
    fail({ message }) {
      rest()
      answer.replaceChildren()
      error.hidden = false
      error.textContent = message
    },
    /** @param {Quote} quote @param {string[]} labels */
    show(quote, labels) {
      rest()
      title.textContent = quote.program || say.common.cycleTime
      about.textContent = say.embed.cam(show.clock(quote.programmed_time_s), show.seconds(quote.programmed_time_s))
      choice.textContent = say.embed.chooseOther
      answer.replaceChildren(make('div', { className: 'scroll' }, table(quote, labels)), ...remarks(quote))
    },
  }
}

/** @param {Quote} quote @param {string[]} labels */
function table({ runs, programmed_time_s: programmed }, labels) {
  const priced = runs.some(({ price }) => price > 0)
  /** A title, how to say it of a run, and whether a narrow place can do without. @type {[string, (run: Quote["runs"][number]) => string, string][]} */
  const columns = [
    [say.common.cycleTime, (run) => show.clock(run.cycle_time_s), 'time'],
    [say.embed.seconds, (run) => show.seconds(run.cycle_time_s), 'minor'],
    [say.embed.againstCam, (run) => show.percent(run.cycle_time_s / programmed - 1), ''],
    [say.common.contourError, (run) => `${show.number(run.max_contour_error_mm * 1000)} µm`, 'minor'],
  ]
  if (priced) columns.push([say.results.price, (run) => show.money(run.price), ''])
  const titles = columns.map(([title, , className]) => make('th', { scope: 'col', className }, title))
  const rows = runs.map((run, index) =>
    make(
      'tr',
      {},
      make('th', { scope: 'row' }, run.tolerances ? say.charts.asProgrammed : show.worded(labels[index])),
      ...columns.map(([, text, className]) => make('td', { className }, text(run))),
    ),
  )
  const made = make('table', {}, make('thead', {}, make('tr', {}, make('th', { scope: 'col' }, say.common.tolerance), ...titles)), make('tbody', {}, ...rows))
  made.setAttribute('part', 'table')
  return made
}

/** What could not be read. @param {Quote} quote */
function remarks({ diagnostics }) {
  if (diagnostics.length === 0) return []
  const first = diagnostics.slice(0, MOST_REMARKS)
  const items = first.map(({ line, severity, message }) => make('li', {}, say.embed.remark(line, severity, message)))
  const more = diagnostics.length - first.length
  if (more > 0) items.push(make('li', {}, say.embed.more(show.count(more))))
  const title = say.embed.remarks(diagnostics.length, show.count(diagnostics.length))
  return [make('details', {}, make('summary', {}, title), make('ul', {}, ...items))]
}

customElements.define('truefeed-quote', QuoteElement)
