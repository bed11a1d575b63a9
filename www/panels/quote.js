// The price: what it is, what is not in it yet, its terms, all it is made of, and its documents. All arithmetic is Rust's.

import { Chart, Offered, termsForm, toleranceLabel } from '../pkg/truefeed_whole.js'
import { addCurve, columnKey, columnsOf, isJob, programInSight, quotedColumn } from '../columns.js'
import { find, make, write } from '../dom.js'
import { field, idOf, same } from '../field.js'
import { amount, between, clock, count, duration, priced, seconds, worded, wordedHtml } from '../format.js'
import { nameOf } from '../job/names.js'
import { isCurrent } from '../job/pricing.js'
import { addressOf, saveFile } from '../save.js'
import { say } from '../texts_later.js'
import { outOfDate } from './results.js'

/** @import { Column, Form, JobReport, Offer, OfferShare, Outcome, Parameter, State, Value } from "../types.js" */

const CHART_PX = /** @type {const} */ ([1040, 560])
/** The machine's own rate is part of the machine, and entered here as well. */
const MACHINE_RATE = 'rates.hourly'
/** The terms an estimator meets first; all others are under “More terms”. */
const FIRST = ['quantity', MACHINE_RATE, 'set_up_min', 'loading_s', 'material', 'margin_percent']

/**
 * @param {HTMLElement} root
 * @param {Form} form
 * @param {{setParameter(key: string, value: Value): void, setTerm(key: string, value: Value): void}} actions
 */
export function mount(root, form, actions) {
  const answer = find(root, '.answer')
  const tables = find(root, '.tables')
  const waits = find(root, '.waits')
  const exporting = /** @type {NodeListOf<HTMLButtonElement>} */ (root.querySelectorAll('.exports button'))
  const pictures = find(root, '.pictures')
  /** @type {Parameter[]} */
  const terms = JSON.parse(termsForm())
  const rate = form.fields.filter(({ key }) => key === MACHINE_RATE)
  const fields = [
    ...terms.map((parameter) => field('term', parameter, actions.setTerm)),
    ...rate.map((parameter) => field('term', { ...parameter, label: say.quote.hourlyRate }, actions.setParameter)),
  ]
  const isFirst = (/** @type {typeof fields[number]} */ { parameter }) => FIRST.includes(parameter.key)
  const place = ({ parameter: { key } = fields[0].parameter }) => FIRST.indexOf(key)
  find(root, '.first').append(
    ...fields
      .filter(isFirst)
      .sort((a, b) => place(a) - place(b))
      .map(({ element }) => element),
  )
  find(root, '.rest').append(...fields.filter((entry) => !isFirst(entry)).map(({ element }) => element))
  find(root, 'form').addEventListener('submit', (event) => event.preventDefault())

  /** @type {State | undefined} */
  let state
  /** Those that are computed, and which of them is quoted. @type {Column[]} */
  let columns = []
  let chosen = -1
  /** The program alone, with its tolerances, tools and operations. @type {Offered | null} */
  let offered = null
  /** What is in sight is of. @type {unknown[]} */
  let shown = []

  const job = () => state?.price?.job ?? null
  /** A job, else the program alone. */
  const whole = () => (state && isJob(state) ? job() : offered)

  /** @param {string} selector @param {(name: string) => void} act */
  function on(selector, act) {
    find(root, selector).addEventListener('click', () => {
      const called = state?.job || program()?.name.replace(/\.[^.]*$/, '') || 'part'
      if (whole() && job()) act(`quote-${called.replace(/[^\w.-]+/g, '-')}`)
    })
  }
  /** A document of Rust in the words of the browser's language. @param {string | undefined} html */
  const documentOf = (html) => wordedHtml(html ?? '', state?.price?.report.currency)
  on('.csv', (name) => saveFile(whole()?.csv() ?? '', 'text/csv', `${name}.csv`))
  on('.json', (name) => saveFile(whole()?.json() ?? '', 'application/json', `${name}.json`))
  on('.customer', (name) => saveFile(documentOf(job()?.offer()), 'text/html', `${name}-customer.html`))
  on('.share', (name) => saveFile(documentOf(job()?.result(...captioned())), 'text/html', `${name}-result.html`))
  on('.html', (name) => {
    const html = state && isJob(state) ? job()?.costing(...captioned()) : offered?.html(...captioned())
    saveFile(documentOf(html), 'text/html', `${name}.html`)
  })
  on('.print', async () => {
    await Promise.all(placePictures().map((picture) => picture.decode()))
    window.print()
  })
  window.addEventListener('beforeprint', () => offered && !root.matches('.stale') && pictures.childElementCount === 0 && placePictures())

  /** The charts on paper. */
  function placePictures() {
    const images = drawn().map(({ svg, caption }) => make('img', { src: addressOf(svg), alt: caption }))
    pictures.replaceChildren(...images)
    return images
  }

  /** The charts, and what each shows. @returns {[string[], string[]]} */
  function captioned() {
    const all = drawn()
    return [all.map(({ svg }) => svg), all.map(({ caption }) => caption)]
  }

  const program = () => state && programInSight(state)

  /** The chart of the tolerance that is quoted as SVG, of each program of the job. @returns {{svg: string, caption: string}[]} */
  function drawn() {
    const now = state
    if (!now) return []
    return now.programs.flatMap((one) => {
      const column = quotedColumn(now, one)
      const run = one.outcome?.runs.get(column)
      if (!one.outcome || !run) return []
      const chart = new Chart()
      const { end, feedrate, rapid, line } = one.outcome.steps
      chart.program(end, feedrate, rapid, line)
      addCurve(chart, column, one.outcome.held, columnKey(column))
      const { distance, feedrate: feed, time, corner, arcs, alongArcs } = run.columns
      chart.fill(distance, feed, time)
      chart.fillErrors(corner, arcs, alongArcs)
      const svg = chart.svg(...CHART_PX)
      chart.free()
      return svg ? [{ svg, caption: now.programs.length > 1 ? `${nameOf(one)}: ${CAPTION}` : CAPTION }] : []
    })
  }

  /** @param {State} now */
  function update(now) {
    state = now
    const outcome = program()?.outcome
    const { machine, terms } = now
    for (const { parameter, show } of fields) {
      const source = parameter.key === MACHINE_RATE ? machine : terms
      const message = source.faults.find(({ key }) => key === parameter.key)?.message ?? ''
      show(source.values[parameter.key] ?? null, message)
    }
    const computed = columnsOf(now, program()).filter((column) => outcome?.runs.has(column))
    if (!same(computed, columns)) columns = computed
    const column = quotedColumn(now, program())
    chosen = columns.indexOf(column)
    const run = outcome?.runs.get(column)?.summary
    root.hidden = chosen < 0 && !isJob(now)
    document.body.classList.toggle('has-quote', !root.hidden)
    const isStale = now.programs.some((one) => one.outcome && !isCurrent(now, one))
    const done = now.programs.filter((one) => one.outcome?.runs.has(quotedColumn(now, one))).length
    root.classList.toggle('stale', isStale)
    // A price of the former motion and the settings of now is of neither.
    const reason = isStale ? outOfDate(now) : isJob(now) && done < now.programs.length ? say.job.waits(count(done), count(now.programs.length)) : ''
    write(waits, reason)
    if (isStale && shown[0] === program()) return allow(false)
    const of = [program(), run, columns, now.price, isJob(now)]
    if (of.length === shown.length && of.every((value, index) => value === shown[index])) return allow(whole() !== null)
    shown = of
    offered?.free()
    offered = null
    pictures.replaceChildren()
    answer.replaceChildren()
    tables.replaceChildren()
    if (!isStale) offer(now, outcome)
    allow(whole() !== null)
  }

  /** Says whether the quote may be taken away. @param {boolean} may */
  function allow(may) {
    for (const button of exporting) button.disabled = !may
  }

  /** Prices what has been computed. @param {State} now @param {Outcome | null | undefined} outcome */
  function offer(now, outcome) {
    if (!now.price) return
    const { report, faults } = now.price
    if (faults) return answer.replaceChildren(make('p', { className: 'fault' }, say.quote.faults, list(faults)))
    const names = report.operations.map(({ name }) => name)
    if (!isJob(now) && outcome) offered = alone(now, outcome)
    const offer = offered ? /** @type {Offer} */ (JSON.parse(offered.json())) : report
    answer.replaceChildren(
      ...headline(
        offer,
        report.missing.map((one) => lacks(one, names)),
      ),
    )
    tables.replaceChildren(...(offered ? madeOf(offer, byPart(/** @type {Offer} */ (offer)), []) : madeOf(offer, byProgram(report), names)))
  }

  /** The offer of the program in sight alone. @param {State} now @param {Outcome} outcome */
  function alone({ machine, terms }, outcome) {
    const severe = (/** @type {string} */ kind) => outcome.summary.diagnostics.filter(({ severity }) => severity === kind).length
    const asked = {
      machine: (program()?.machine ?? machine).values,
      terms: { ...terms.values, ...ownTerms(program()) },
      program: program()?.name ?? '',
      // As ISO writes it, by the clock of the user.
      date: new Date().toLocaleDateString('sv'),
      programmed_time_s: outcome.summary.programmed_time_s,
      remarks: { errors: severe('error'), warnings: severe('warning') },
      // What machines read has a decimal point.
      runs: columns.map((column) => ({ ...outcome.runs.get(column)?.summary, tolerance: column === null ? say.charts.asProgrammed : toleranceLabel(column) })),
      chosen,
    }
    return new Offered(JSON.stringify(asked))
  }

  return { update }
}

const CAPTION = say.quote.picture

/** The terms that an operation has of its own. @param {import("../types.js").Program | undefined} program */
function ownTerms(program) {
  const { setUp = null, loading = null } = program ?? {}
  return { ...(setUp === null ? {} : { set_up_min: setUp }), ...(loading === null ? {} : { loading_s: loading }) }
}

/** What the price lacks, in words. @param {{label: string, operation: number | null}} missing @param {string[]} names */
const lacks = ({ label, operation }, names) => (operation === null ? label.toLowerCase() : `${label.toLowerCase()} (${names[operation]})`)

/** What is wrong, in one line. @param {string} faults  JSON */
function list(faults) {
  const all = /** @type {{key: string | null, message: string}[]} */ (JSON.parse(faults))
  return all.map(({ key, message }) => (key ? `${key}: ${message}` : message)).join('; ')
}

/** How an offer writes amounts, and those of one part, in tables and with the currency. @param {{decimals: number, currency: string}} offer */
function writers({ decimals, currency }) {
  const ofPart = Math.max(2, decimals)
  return {
    money: (/** @type {number} */ value) => amount(value, decimals),
    each: (/** @type {number} */ value) => amount(value, ofPart),
    inFull: (/** @type {number} */ value) => priced(value, currency, decimals),
    eachInFull: (/** @type {number} */ value) => priced(value, currency, ofPart),
  }
}

/** The price, and what is not in it. @param {Offer | JobReport} offer @param {string[]} lacking */
function headline(offer, lacking) {
  const { inFull, eachInFull } = writers(offer)
  const { batch, uncertainty } = offer
  const facts = offer.facts.map(({ name, value }) => make('div', {}, make('dt', {}, name), make('dd', {}, worded(value))))
  const of = make('dl', { className: 'on-paper' }, ...facts)
  const ends = uncertainty.cycle_time_s
  const time = say.quote.timeOfPart(duration(offer.cycle_time_s), ends ? between(ends, duration) : '')
  const sure = make('p', { className: `sure ${uncertainty.kind}` }, make('b', {}, say.quote.cycleTime(time)), worded(uncertainty.sentence))
  const behind = make('details', { className: 'confidence' }, make('summary', {}, say.quote.confidence), sure)
  // Where nothing costs anything, a price of nothing would be taken for one.
  if (offer.addends.length === 0) {
    const rate = make('a', { href: `#${idOf('term', MACHINE_RATE)}` }, say.results.giveRate)
    return [of, make('p', { className: 'headline none' }, make('b', {}, say.quote.noPrice)), make('p', {}, rate), behind]
  }
  const range = batch.unit_price_range ? ` · ${between(batch.unit_price_range, eachInFull)}` : ''
  const isBatch = batch.quantity > 1
  const parts = say.quote.parts(batch.quantity, count(batch.quantity))
  return [
    of,
    make('p', { className: 'of' }, isBatch ? parts : say.quote.eachPart),
    make('p', { className: 'headline' }, make('b', {}, isBatch ? inFull(batch.total) : eachInFull(batch.unit_price))),
    make('p', { className: 'each' }, isBatch ? say.quote.aPart(eachInFull(batch.unit_price)) : '', isBatch ? range : range.slice(3)),
    ...(lacking.length > 0 ? [make('p', { className: 'lacking' }, make('b', {}, say.quote.notInPrice), lacking.join(', '))] : []),
    behind,
  ]
}

/** What the price is made of. @param {Offer | JobReport} offer @param {HTMLElement} parts  by what it can be divided @param {string[]} names  of operations, where there are several */
function madeOf(offer, parts, names) {
  if (offer.addends.length === 0) return []
  const { money, each } = writers(offer)
  const { batch, currency } = offer
  const range = (/** @type {[number, number] | null} */ ends) => (ends ? between(ends, money) : say.quote.unknown)
  const quantity = say.quote.parts(batch.quantity, count(batch.quantity))
  const rows = offer.addends.map(({ item, basis, once, amount: value, of_batch: all, ...addend }) => {
    const of = 'operation' in addend ? names[/** @type {number} */ (addend.operation)] : undefined
    return row(of ? `${of}: ${item}` : item, [once ? money(value) : '', once ? '' : money(value), money(all)], worded(basis))
  })
  rows.push(sum(say.quote.total, [money(offer.once), money(offer.part), money(batch.total)]))
  const breaks = offer.breaks.map((other) => row(count(other.quantity), [each(other.unit_price), money(other.total), range(other.total_range)]))
  return [
    folded(
      say.quote.madeOf,
      table(say.quote.madeOf, ['', say.quote.once, say.quote.eachPart, `${quantity}${currency ? `, ${currency}` : ''}`], rows),
      ...offer.notes.map((note) => make('p', { className: 'help' }, worded(note))),
    ),
    folded(say.quote.byQuantity, table(say.quote.byQuantity, [say.quote.quantity, say.quote.eachPart, say.quote.total, say.quote.ifOff], breaks)),
    parts,
  ]
}

/** @param {string} title @param {HTMLElement[]} content */
const folded = (title, ...content) => make('details', {}, make('summary', {}, title), ...content)

/** A program by its operations, tools and tolerances. @param {Offer} offer */
function byPart(offer) {
  const { money, each } = writers(offer)
  const parts = say.quote.parts(offer.batch.quantity, count(offer.batch.quantity))
  const tolerances = offer.tolerances.map(({ tolerance, cycle_time_s: own, unit_price: one, total }) => row(worded(tolerance), [clock(own), each(one), money(total)]))
  const cost = [seconds(offer.cycle_time_s), money(offer.cycle_cost)]
  const shares = (/** @type {OfferShare[]} */ all) => [
    ...all.map(({ name, line, time_s: own, amount: value }) => row(name, [seconds(own), money(value)], line === null ? '' : say.quote.line(line))),
    sum(say.common.together, cost),
  ]
  const heads = [say.common.contourTolerance, say.common.cycleTime, say.quote.eachPart, parts]
  return folded(
    say.quote.byOperation,
    table(say.quote.operations, ['', say.common.time, say.quote.cost], shares(offer.operations)),
    table(say.quote.tools, ['', say.common.time, say.quote.cost], shares(offer.tools)),
    ...(offer.tolerances.length > 0 ? [table(say.quote.byTolerance, heads, tolerances)] : []),
  )
}

/** A job by its programs. @param {JobReport} job */
function byProgram(job) {
  const { money } = writers(job)
  const rows = job.operations.map(({ name, program, machine, tolerance, set_up_s: setUp, cycle_time_s: cycle, set_up_cost: once, part_cost: part }) =>
    row(name, [clock(setUp), clock(cycle), money(once), money(part)], worded([program, machine, tolerance].join(', '))),
  )
  const together = [clock(job.set_up_s), clock(job.cycle_time_s), '', '']
  const heads = ['', say.job.setUp, say.common.time, say.quote.once, say.quote.eachPart]
  return folded(say.job.operations, table(say.job.operationsMade, heads, [...rows, sum(say.common.together, together)]))
}

/** @param {string} title @param {string[]} cells @param {string} [basis]  what the title is made of */
function row(title, cells, basis = '') {
  const below = basis ? [' ', make('span', { className: 'basis' }, basis)] : []
  return make('tr', {}, make('th', { scope: 'row' }, title, ...below), ...cells.map((cell) => make('td', {}, cell)))
}

/** @param {string} title @param {string[]} cells */
function sum(title, cells) {
  return Object.assign(row(title, cells), { className: 'sum' })
}

/** @param {string} caption @param {string[]} titles @param {HTMLElement[]} rows */
function table(caption, titles, rows) {
  const head = titles.map((title) => (title ? make('th', { scope: 'col' }, title) : make('td', {})))
  const body = make('table', {}, make('caption', {}, caption), make('thead', {}, make('tr', {}, ...head)), make('tbody', {}, ...rows))
  const place = make('div', { className: 'scroll', tabIndex: 0 }, body)
  // Focus lets the keys scroll what is wider than the page.
  place.setAttribute('role', 'group')
  place.setAttribute('aria-label', caption)
  return place
}
