// Numbers, lengths and durations as people read them: texts are English, numbers are written as the browser's language does. Lengths
// are converted only here, to the chosen unit. Rust gives its size, symbols and decimals.

/** @import { LengthUnit } from "./types.js" */

/** A language with the digits 0 to 9, which the charts have and all inputs take. @param {string} language */
const inDigits = (language) => new Intl.Locale(language || 'en', { numberingSystem: 'latn' })
const LOCALE = inDigits(navigator.language)

const decimals = (/** @type {number} */ count) => new Intl.NumberFormat(LOCALE, { minimumFractionDigits: count, maximumFractionDigits: count })

const none = decimals(0)
const one = decimals(1)
const two = decimals(2)
const first = new Intl.NumberFormat(LOCALE, { maximumSignificantDigits: 1 })
const four = new Intl.NumberFormat(LOCALE, { maximumSignificantDigits: 4 })
const plain = new Intl.NumberFormat(LOCALE, { maximumSignificantDigits: 12, useGrouping: false })
const sizes = new Intl.NumberFormat(LOCALE, { style: 'unit', unit: 'kilobyte', maximumSignificantDigits: 3 })

/** A duration as h:mm:ss. @param {number} seconds */
export function clock(seconds) {
  const whole = Math.round(seconds)
  const two = (/** @type {number} */ value) => String(value).padStart(2, '0')
  return `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`
}

/** One decimal, where that matters. @param {number} value */
const short = (value) => (Math.abs(value) < 1000 ? one : none).format(value)

/** Seconds. @param {number} value */
export const seconds = (value) => `${short(value)} s`

/** The sign of a number as it is written; nothing has none. @param {number} value @param {string} written */
const sign = (value, written) => (/[1-9]/.test(written) ? (value < 0 ? '−' : '+') : '')

/** A signed difference in seconds. @param {number} value */
export function difference(value) {
  const written = short(Math.abs(value))
  return `${sign(value, written)}${written} s`
}

/** A duration as one says it: seconds below a minute. @param {number} value */
export const duration = (value) => (value < 59.95 ? seconds(value) : clock(value))

/** A signed difference of durations. @param {number} value */
export const signed = (value) => (Math.abs(value) < 59.95 ? difference(value) : `${value < 0 ? '−' : '+'}${clock(Math.abs(value))}`)

/** Two ends of a range. @param {[number, number]} ends @param {(value: number) => string} write */
export const between = ([low, high], write) => (write(low) === write(high) ? write(low) : `${write(low)} – ${write(high)}`)

/** A signed ratio as a percentage. @param {number} ratio */
export function percent(ratio) {
  if (!Number.isFinite(ratio)) return '–'
  const written = short(Math.abs(ratio) * 100)
  return `${sign(ratio, written)}${written} %`
}

/** An amount of money, in whatever currency the rate is. @param {number} value */
export const money = (value) => two.format(value)

/** An amount with so many decimals. @param {number} value @param {number} count */
export const amount = (value, count) => decimals(count).format(value)

/** Formats of currencies, by code and decimals; null where a code is none of a currency. @type {Map<string, Intl.NumberFormat | null>} */
const currencies = new Map()

/** @param {string} code @param {number} count */
function currencyFormat(code, count) {
  const key = `${code} ${count}`
  const known = currencies.get(key)
  if (known !== undefined) return known
  let format = null
  try {
    format = new Intl.NumberFormat(LOCALE, { style: 'currency', currency: code, minimumFractionDigits: count, maximumFractionDigits: count })
  } catch {
    // What the user calls the currency may be any word.
  }
  currencies.set(key, format)
  return format
}

/** An amount in a currency, as the browser's language writes it: €1,325.00. @param {number} value @param {string} currency  a code such as EUR, or any word @param {number} count  decimals */
export const priced = (value, currency, count) => currencyFormat(currency, count)?.format(value) ?? `${amount(value, count)} ${currency}`.trim()

/** The unit in which lengths are shown. @type {LengthUnit} */
let unit
let [lengths, feedrates] = [two, none]

/** Shows lengths in a unit from now on. @param {LengthUnit} chosen */
export function showLengthsIn(chosen) {
  unit = chosen
  lengths = decimals(unit.decimals)
  feedrates = decimals(unit.feed_decimals)
}

/** The word of that unit, which Rust asks for as well. */
export const lengthWord = () => unit.word

/** The symbol of tolerances and errors. */
export const fineSymbol = () => unit.fine_symbol

/** The symbols of lengths and of feedrates. */
export const lengthSymbols = () => [unit.symbol, unit.feed_symbol]

/** A length as a number in the unit shown. @param {number} value  mm */
export const inLengthUnit = (value) => value / unit.in_mm

/** A feedrate without its unit. @param {number} value  mm/min */
export const feedNumber = (value) => feedrates.format(inLengthUnit(value))

/** A feedrate. @param {number} value  mm/min */
export const feedrate = (value) => `${feedNumber(value)} ${unit.feed_symbol}`

/** A length. @param {number} value  mm */
export const lengthLabel = (value) => `${lengths.format(inLengthUnit(value))} ${unit.symbol}`

/** The length of a scale bar, a round number in the unit shown. @param {number} value  mm */
export const roundLength = (value) => `${four.format(inLengthUnit(value))} ${unit.symbol}`

/** A number in about three figures. @param {number} value */
export const number = (value) => (Math.abs(value) < 10 ? two : Math.abs(value) < 1000 ? one : none).format(value)

/** A count. @param {number} value */
export const count = (value) => none.format(value)

/** The size of a file. @param {number} bytes */
export const size = (bytes) => sizes.format(Math.max(bytes, 1) / 1000)

/** A number in four figures. @param {number} value */
export const figures = (value) => four.format(value)

/** A number of which one figure is known, and two from ten on. @param {number} value */
export const roughly = (value) => (value < 9.5 ? first : none).format(value)

/** A number as it is typed: all its digits, none set apart. @param {number} value */
export const typed = (value) => plain.format(value)

/** What writes numbers on the axes of charts, with so many decimals at most. @param {string} language */
export function axisIn(language) {
  const locale = inDigits(language)
  /** @type {Intl.NumberFormat[]} */
  const formats = []
  return (/** @type {number} */ value, /** @type {number} */ count) => {
    const format = formats[count] ?? (formats[count] = new Intl.NumberFormat(locale, { maximumFractionDigits: count }))
    return format.format(value + 0).replace('-', '−')
  }
}

export const axis = axisIn(navigator.language)

const SIGN = axis(0.5, 1).charAt(1)
/** A number with a decimal point; words of programs (G61.1, DEF 7.1), names of files, sections and versions hold none. */
const DECIMAL = /(?<![\w./]|(?:Sect\.|DEF|doi) )(\d+)\.(\d+)(?!\w|\.\w|\/)/g
/** What is between the tags of a document, or what has its numbers as they should be: charts and styles. */
const BETWEEN = /<(style|svg)\b.*?<\/\1>|>[^<]+</gs

/** A text of Rust with its numbers as the browser's language writes them. @param {string} text */
export const worded = (text) => (SIGN === '.' ? text : text.replace(DECIMAL, `$1${SIGN}$2`))

/** Thousands as documents of Rust set them apart, and as the browser's language does. */
const GROUPED = /(?<=\d)\u202f(?=\d{3})/g
const GROUP = none.formatToParts(12345).find(({ type }) => type === 'group')?.value ?? ''

/** Amounts in a currency, in a text of a document. @param {string} text @param {string} currency */
function withCurrency(text, currency) {
  if (!/^\w+$/.test(currency)) return text
  const written = new RegExp(`(−?)([\\d\u202f]+)(?:[.,](\\d+))? ${currency}\\b`, 'g')
  return text.replace(written, (_, sign, whole, rest = '') => priced(Number(`${whole.replaceAll('\u202f', '')}.${rest}`) * (sign ? -1 : 1), currency, rest.length))
}

/** The same in a document, whose amounts are in a currency where one is named. @param {string} html @param {string} [currency] */
export const wordedHtml = (html, currency = '') => html.replace(BETWEEN, (part) => (part.startsWith('>') ? withCurrency(worded(part), currency).replace(GROUPED, GROUP) : part))

/** Thousands or thousandths, nobody knows: three digits behind a sign that is not the decimal sign of the language. */
const UNCLEAR = SIGN === ',' ? /^-?[1-9]\d{0,2}\.\d{3}$/ : /^-?[1-9]\d{0,2},\d{3}$/

/** What an input says, as a number; NaN where it is none, or may be two. A comma is a decimal comma. @param {string} written */
export function parsed(written) {
  const text = written.trim().replace('−', '-')
  return text === '' || UNCLEAR.test(text) ? NaN : Number(text.replace(',', '.'))
}
