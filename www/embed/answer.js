// What stands in <truefeed-quote>: the answer large, the path as a picture, the tables, what could not be read.

import { make } from '../dom.js'
import * as show from '../format.js'
import { say } from '../texts_later.js'

/** @import { Quote, Refusal } from "../../npm/index.d.ts" */

const MOST_REMARKS = 20

/** What stands in the element, and how it changes. @param {ShadowRoot} root */
export function skeleton(root) {
  const input = make('input', { type: 'file', multiple: true, ariaLabel: say.embed.choose })
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
    /** @param {Quote[]} quotes @param {string[]} labels @param {string} currency @param {string | undefined} picture  SVG */
    show(quotes, labels, currency, picture) {
      rest()
      const programmed = sum(quotes, (quote) => quote.programmed_time_s)
      title.textContent =
        quotes
          .map(({ program }) => program)
          .filter(Boolean)
          .join(' + ') || say.common.cycleTime
      about.textContent = say.embed.cam(show.clock(programmed), show.seconds(programmed))
      choice.textContent = say.embed.chooseOther
      const tables = [table(quotes, labels, currency), ...(quotes.length > 1 ? [programsTable(quotes, currency)] : [])]
      answer.replaceChildren(
        ...headline(quotes, labels, currency),
        ...(picture ? [pictureOf(picture)] : []),
        ...tables.map((made) => make('div', { className: 'scroll' }, made)),
        ...quotes.flatMap(remarks),
      )
    },
  }
}

/** @param {Quote[]} quotes @param {(quote: Quote) => number} of */
const sum = (quotes, of) => quotes.reduce((total, quote) => total + of(quote), 0)

/** An amount, in a currency where one is named. @param {number} value @param {string} currency */
const money = (value, currency) => (currency ? show.priced(value, currency, 2) : show.money(value))

/** What a tolerance is called. @param {Quote["runs"][number]} run @param {string} label */
const nameOf = (run, label) => (run.tolerances ? say.charts.asProgrammed : show.worded(label))

/** The answer at the first tolerance: time and price of a part. @param {Quote[]} quotes @param {string[]} labels @param {string} currency */
function headline(quotes, labels, currency) {
  const [first] = quotes[0].runs
  if (!first) return []
  const price = sum(quotes, ({ runs }) => runs[0].price)
  const words = [
    make('b', {}, show.clock(sum(quotes, ({ runs }) => runs[0].cycle_time_s))),
    ...(price > 0 ? [' ', make('b', { className: 'price' }, money(price, currency))] : []),
    ' ',
    make('span', { className: 'about' }, say.embed.perPart(nameOf(first, labels[0]))),
  ]
  const made = make('p', { className: 'headline' }, ...words)
  made.setAttribute('part', 'headline')
  return [made]
}

/** The path, as a picture that runs nothing. @param {string} svg */
function pictureOf(svg) {
  const picture = make('img', { alt: say.embed.picture, src: `data:image/svg+xml,${encodeURIComponent(svg)}` })
  picture.setAttribute('part', 'picture')
  return picture
}

/** By tolerance, all programs together. @param {Quote[]} quotes @param {string[]} labels @param {string} currency */
function table(quotes, labels, currency) {
  const { runs } = quotes[0]
  const programmed = sum(quotes, (quote) => quote.programmed_time_s)
  const time = (/** @type {number} */ index) => sum(quotes, (quote) => quote.runs[index].cycle_time_s)
  const price = (/** @type {number} */ index) => sum(quotes, (quote) => quote.runs[index].price)
  const priced = runs.some((_, index) => price(index) > 0)
  /** A title, how to say it of a tolerance, and whether a narrow place can do without. @type {[string, (index: number) => string, string][]} */
  const columns = [
    [say.common.cycleTime, (index) => show.clock(time(index)), 'time'],
    [say.embed.seconds, (index) => show.seconds(time(index)), 'minor'],
    [say.embed.againstCam, (index) => show.percent(time(index) / programmed - 1), ''],
    [say.common.contourError, (index) => `${show.number(Math.max(...quotes.map((quote) => quote.runs[index].max_contour_error_mm)) * 1000)} µm`, 'minor'],
  ]
  if (priced) columns.push([say.compare.price, (index) => money(price(index), currency), ''])
  const titles = columns.map(([title, , className]) => make('th', { scope: 'col', className }, title))
  const rows = runs.map((run, index) => make('tr', {}, make('th', { scope: 'row' }, nameOf(run, labels[index])), ...columns.map(([, text, className]) => make('td', { className }, text(index)))))
  const made = make('table', {}, make('thead', {}, make('tr', {}, make('th', { scope: 'col' }, say.common.tolerance), ...titles)), make('tbody', {}, ...rows))
  made.setAttribute('part', 'table')
  return made
}

/** By program, at the first tolerance. @param {Quote[]} quotes @param {string} currency */
function programsTable(quotes, currency) {
  const priced = quotes.some(({ runs }) => runs[0].price > 0)
  const rows = quotes.map(({ program, runs: [run], programmed_time_s: programmed }) =>
    make(
      'tr',
      {},
      make('th', { scope: 'row' }, program),
      ...[show.clock(run.cycle_time_s), show.percent(run.cycle_time_s / programmed - 1), ...(priced ? [money(run.price, currency)] : [])].map((text) => make('td', {}, text)),
    ),
  )
  const titles = [say.embed.program, say.common.cycleTime, say.embed.againstCam, ...(priced ? [say.compare.price] : [])].map((title) => make('th', { scope: 'col' }, title))
  const made = make('table', {}, make('thead', {}, make('tr', {}, ...titles)), make('tbody', {}, ...rows))
  made.setAttribute('part', 'programs')
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
