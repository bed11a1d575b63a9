// Numbers and durations as people read them: texts are English, numbers are written as the browser's language does.

/** With the digits 0 to 9, which the charts have and all inputs take. */
const LOCALE = new Intl.Locale(navigator.language || 'en', { numberingSystem: 'latn' })

const decimals = (/** @type {number} */ count) =>
  new Intl.NumberFormat(LOCALE, { minimumFractionDigits: count, maximumFractionDigits: count })

const none = decimals(0)
const one = decimals(1)
const two = decimals(2)
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

/** A feedrate in mm/min. @param {number} value */
export const feedrate = (value) => `${none.format(value)} mm/min`

/** A length in mm. @param {number} value */
export const millimetres = (value) => `${two.format(value)} mm`

/** A number in about three figures. @param {number} value */
export const number = (value) => (Math.abs(value) < 10 ? two : Math.abs(value) < 1000 ? one : none).format(value)

/** A count. @param {number} value */
export const count = (value) => none.format(value)

/** The size of a file. @param {number} bytes */
export const size = (bytes) => sizes.format(Math.max(bytes, 1) / 1000)

/** A number in four figures. @param {number} value */
export const figures = (value) => four.format(value)

/** A number as it is typed: all its digits, none set apart. @param {number} value */
export const typed = (value) => plain.format(value)

/** A number on the axis of a chart, with so many decimals at most. @param {number} value @param {number} count */
export function axis(value, count) {
  const format = axes[count] ?? (axes[count] = new Intl.NumberFormat(LOCALE, { maximumFractionDigits: count }))
  return format.format(value + 0).replace('-', '−')
}

/** @type {Intl.NumberFormat[]} */
const axes = []

const SIGN = axis(0.5, 1).charAt(1)
/** A number with a decimal point; words of programs (G61.1, DEF 7.1), names of files, sections and versions hold none. */
const DECIMAL = /(?<![\w./]|(?:Sect\.|DEF|doi) )(\d+)\.(\d+)(?!\w|\.\w|\/)/g
/** What is between the tags of a document, or what has its numbers as they should be: charts and styles. */
const BETWEEN = /<(style|svg)\b[^]*?<\/\1>|>[^<]+</g

/** A text of Rust with its numbers as the browser's language writes them. @param {string} text */
export const worded = (text) => (SIGN === '.' ? text : text.replace(DECIMAL, `$1${SIGN}$2`))

/** The same in a document. @param {string} html */
export const wordedHtml = (html) => html.replace(BETWEEN, (part) => (part.startsWith('>') ? worded(part) : part))

/** Thousands or thousandths, nobody knows: three digits behind a sign that is not the decimal sign of the language. */
const UNCLEAR = SIGN === ',' ? /^-?[1-9]\d{0,2}\.\d{3}$/ : /^-?[1-9]\d{0,2},\d{3}$/

/** What an input says, as a number; NaN where it is none, or may be two. A comma is a decimal comma. @param {string} written */
export function parsed(written) {
  const text = written.trim().replace('−', '-')
  return text === '' || UNCLEAR.test(text) ? NaN : Number(text.replace(',', '.'))
}
