// The quote: terms on one side, the price with all it is made of on the other, and its documents. All arithmetic is Rust's.

import { Chart, Offered, termsForm, toleranceLabel } from '../pkg/truefeed_whole.js'
import { addCurve, columnLabel, columnsOf } from '../columns.js'
import { find, make } from '../dom.js'
import { field, idOf, same } from '../field.js'
import { amount, clock, count, seconds, worded, wordedHtml } from '../format.js'
import { addressOf, saveFile } from '../save.js'
import { say } from '../texts_later.js'
import { outOfDate } from './results.js'

/** @import { Column, Form, Offer, OfferShare, Outcome, Parameter, State, Value } from "../types.js" */

const CHART_PX = /** @type {const} */ ([1040, 560])
/** The machine's own rate is part of the machine, and entered here as well. */
const MACHINE_RATE = 'rates.hourly'

/**
 * @param {HTMLElement} root
 * @param {Form} form
 * @param {{setParameter(key: string, value: Value): void, setTerm(key: string, value: Value): void, setQuoted(tolerance: string): void}} actions
 */
export function mount(root, form, actions) {
  const chosen = /** @type {HTMLSelectElement} */ (find(root, '.at select'))
  const answer = find(root, '.answer')
  const waits = find(root, '.waits')
  const exporting = /** @type {NodeListOf<HTMLButtonElement>} */ (root.querySelectorAll('.exports button'))
  const pictures = find(root, '.pictures')
  /** @type {Parameter[]} */
  const terms = JSON.parse(termsForm())
  const fields = terms.map((parameter) => field('term', parameter, actions.setTerm))
  const rate = form.fields
    .filter(({ key }) => key === MACHINE_RATE)
    .map((parameter) => field('term', { ...parameter, label: say.quote.hourlyRate }, actions.setParameter))
  // Beside the operator's.
  const before = fields.findIndex(({ parameter }) => parameter.key === 'operator_hourly')
  find(root, '.fields').append(...[...fields.slice(0, before), ...rate, ...fields.slice(before)].map(({ element }) => element))
  find(root, 'form').addEventListener('submit', (event) => event.preventDefault())

  /** @type {State | undefined} */
  let state
  /** @type {Column[]} */
  let columns = []
  /** @type {Offered | null} */
  let offered = null
  /** What is in sight is of. @type {unknown[]} */
  let shown = []

  chosen.addEventListener('change', () => actions.setQuoted(chosen.value))

  /** @param {string} selector @param {(offered: Offered, name: string) => void} act */
  function on(selector, act) {
    find(root, selector).addEventListener('click', () => {
      const name = program()?.name.replace(/\.[^.]*$/, '').replace(/[^\w.-]+/g, '-') ?? 'part'
      if (offered) act(offered, `quote-${name}`)
    })
  }
  on('.csv', (offer, name) => saveFile(offer.csv(), 'text/csv', `${name}.csv`))
  on('.json', (offer, name) => saveFile(offer.json(), 'application/json', `${name}.json`))
  on('.html', (offer, name) => {
    const charts = drawn()
    const html = wordedHtml(offer.html(charts, charts.map(() => CAPTION)))
    saveFile(html, 'text/html', `${name}.html`)
  })
  on('.print', async () => {
    await Promise.all(placePictures().map((picture) => picture.decode()))
    window.print()
  })
  window.addEventListener('beforeprint', () => offered && !root.matches('.stale') && pictures.childElementCount === 0 && placePictures())

  /** The charts on paper. */
  function placePictures() {
    const images = drawn().map((svg) => make('img', { src: addressOf(svg), alt: CAPTION }))
    pictures.replaceChildren(...images)
    return images
  }

  const program = () => state?.programs.find(({ id }) => id === state?.selected)

  /** The chart of the tolerance in sight as SVG. */
  function drawn() {
    const outcome = program()?.outcome
    const column = columns[chosen.selectedIndex]
    const run = outcome?.runs.get(column)
    if (!outcome || !run) return []
    const chart = new Chart()
    const { end, feedrate, rapid, line } = outcome.steps
    chart.program(end, feedrate, rapid, line)
    addCurve(chart, column, outcome.held)
    const { distance, feedrate: feed, time, corner, arcs, alongArcs } = run.columns
    chart.fill(distance, feed, time)
    chart.fillErrors(corner, arcs, alongArcs)
    const svg = chart.svg(...CHART_PX)
    chart.free()
    return svg ? [svg] : []
  }

  /** @param {State} now */
  function update(now) {
    state = now
    const outcome = program()?.outcome
    const { machine, terms } = now
    for (const { parameter, show } of [...fields, ...rate]) {
      const source = parameter.key === MACHINE_RATE ? machine : terms
      const message = source.faults.find(({ key }) => key === parameter.key)?.message ?? ''
      show(source.values[parameter.key] ?? null, message)
    }
    choices(now, outcome)
    if (columns.some((column) => columnLabel(column) === now.quoted)) chosen.value = now.quoted
    const column = columns[chosen.selectedIndex]
    const run = outcome?.runs.get(column)?.summary
    root.hidden = columns.length === 0
    document.body.classList.toggle('has-quote', !root.hidden)
    const isStale = Boolean(outcome) && outcome?.motion !== machine.motion
    root.classList.toggle('stale', isStale)
    // A price of the former motion and the settings of now is of neither.
    const reason = isStale ? outOfDate(now) : ''
    if (waits.textContent !== reason) waits.textContent = reason
    if (isStale && shown[0] === program()) return allow(false)
    const of = [program(), run, machine.values, terms.values, columns]
    if (of.every((value, index) => value === shown[index])) return allow(offered !== null)
    shown = of
    offered?.free()
    offered = null
    pictures.replaceChildren()
    answer.replaceChildren()
    if (run && outcome && !isStale) offer(now, outcome)
    allow(offered !== null)
  }

  /** Says whether the quote may be taken away. @param {boolean} may */
  function allow(may) {
    for (const button of exporting) button.disabled = !may
  }

  /** Prices what has been computed. @param {State} now @param {Outcome} outcome */
  function offer({ machine, terms }, outcome) {
    const severe = (/** @type {string} */ kind) => outcome.summary.diagnostics.filter(({ severity }) => severity === kind).length
    const asked = {
      machine: machine.values,
      terms: terms.values,
      program: program()?.name ?? '',
      // As ISO writes it, by the clock of the user.
      date: new Date().toLocaleDateString('sv'),
      programmed_time_s: outcome.summary.programmed_time_s,
      remarks: { errors: severe('error'), warnings: severe('warning') },
      // What machines read has a decimal point.
      runs: columns.map((column) => ({ ...outcome.runs.get(column)?.summary, tolerance: column === null ? say.charts.asProgrammed : toleranceLabel(column) })),
      chosen: chosen.selectedIndex,
    }
    try {
      offered = new Offered(JSON.stringify(asked))
      answer.replaceChildren(...priced(JSON.parse(offered.json())))
    } catch (faults) {
      if (typeof faults !== 'string') throw faults
      answer.replaceChildren(make('p', { className: 'fault' }, say.quote.faults, list(faults)))
    }
  }

  /** The tolerances that can be quoted. @param {State} now @param {Outcome | null | undefined} outcome */
  function choices(now, outcome) {
    const computed = columnsOf(now, outcome).filter((column) => outcome?.runs.has(column))
    if (same(computed, columns)) return
    columns = [...computed]
    chosen.replaceChildren(...columns.map((column) => make('option', {}, columnLabel(column))))
  }

  return { update }
}

const CAPTION = say.quote.picture

/** What is wrong, in one line. @param {string} faults  JSON */
function list(faults) {
  const all = /** @type {{key: string | null, message: string}[]} */ (JSON.parse(faults))
  return all.map(({ key, message }) => (key ? `${key}: ${message}` : message)).join('; ')
}

/** The price and what it is made of. @param {Offer} offer */
function priced(offer) {
  const money = (/** @type {number} */ value) => amount(value, offer.decimals)
  const each = (/** @type {number} */ value) => amount(value, Math.max(2, offer.decimals))
  const { batch, uncertainty, currency } = offer
  const range = (/** @type {[number, number] | null} */ ends, /** @type {(value: number) => string} */ write) =>
    ends ? `${write(ends[0])} – ${write(ends[1])}` : say.quote.unknown
  const parts = say.quote.parts(batch.quantity, count(batch.quantity))
  const headline = make(
    'p',
    { className: 'headline' },
    make('b', {}, `${each(batch.unit_price)} ${currency}`.trim()),
    say.quote.aPart,
    batch.quantity > 1 ? say.quote.batch(money(batch.total), currency, parts) : '',
  )
  const ends = uncertainty.cycle_time_s
  const time = say.quote.timeOfPart(clock(offer.cycle_time_s), seconds(offer.cycle_time_s), ends ? range(ends, seconds) : '')
  const rows = offer.addends.map(({ item, basis, once, amount: value, of_batch: whole }) =>
    row(item, [once ? money(value) : '', once ? '' : money(value), money(whole)], worded(basis)),
  )
  rows.push(sum(say.quote.total, [money(offer.once), money(offer.part), money(batch.total)]))
  const breaks = offer.breaks.map((other) =>
    row(count(other.quantity), [each(other.unit_price), money(other.total), range(other.total_range, money)]),
  )
  const tolerances = offer.tolerances.map(({ tolerance, cycle_time_s: own, unit_price: one, total }) =>
    row(worded(tolerance), [clock(own), each(one), money(total)]),
  )
  const cost = [seconds(offer.cycle_time_s), money(offer.cycle_cost)]
  const shares = (/** @type {OfferShare[]} */ all) => [
    ...all.map(({ name, line, time_s: own, amount: value }) =>
      row(name, [seconds(own), money(value)], line === null ? '' : say.quote.line(line)),
    ),
    sum(say.common.together, cost),
  ]
  const byPart = make(
    'details',
    {},
    make('summary', {}, say.quote.byOperation),
    table(say.quote.operations, ['', say.common.time, say.quote.cost], shares(offer.operations)),
    table(say.quote.tools, ['', say.common.time, say.quote.cost], shares(offer.tools)),
  )
  const facts = offer.facts.map(({ name, value }) => make('div', {}, make('dt', {}, name), make('dd', {}, worded(value))))
  const of = make('dl', { className: 'on-paper' }, ...facts)
  const sure = make('p', { className: `sure ${uncertainty.kind}` }, make('b', {}, say.quote.cycleTime(time)), worded(uncertainty.sentence))
  // Where nothing costs anything, a price of nothing would be taken for one.
  if (offer.addends.length === 0) {
    const rate = make('a', { href: `#${idOf('term', MACHINE_RATE)}` }, say.results.giveRate)
    return [of, make('p', { className: 'headline' }, make('b', {}, say.quote.noPrice)), make('p', {}, rate), sure]
  }
  return [
    of,
    headline,
    sure,
    table(say.quote.madeOf, ['', say.quote.once, say.quote.eachPart, `${parts}${currency ? `, ${currency}` : ''}`], rows),
    table(say.quote.byQuantity, [say.quote.quantity, say.quote.eachPart, say.quote.total, say.quote.ifOff], breaks),
    ...(tolerances.length > 0 ? [table(say.quote.byTolerance, [say.common.contourTolerance, say.common.cycleTime, say.quote.eachPart, parts], tolerances)] : []),
    byPart,
    ...offer.notes.map((note) => make('p', { className: 'help' }, worded(note))),
  ]
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
  const body = make(
    'table',
    {},
    make('caption', {}, caption),
    make('thead', {}, make('tr', {}, ...head)),
    make('tbody', {}, ...rows),
  )
  const place = make('div', { className: 'scroll', tabIndex: 0 }, body)
  // Focus lets the keys scroll what is wider than the page.
  place.setAttribute('role', 'group')
  place.setAttribute('aria-label', caption)
  return place
}
