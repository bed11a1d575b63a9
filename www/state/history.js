// The document of the page, and every state it had: all that a user changes is in it, nothing is ever changed in place, so that
// one undo takes any change back. What is computed from it is not here.

/** @import { Before, Calibration, Preset, Values } from "../types.js" */

/** @import { OfJob, OfOperation } from "../job/document.js" */

/** A program as it was given, and what it is in the job. @typedef {{readonly id: number, readonly name: string, readonly file: Blob, readonly dialect: string | null} & Readonly<OfOperation>} GivenProgram */
/** A recording that the user gave. `program` is null if Truefeed chooses the program by the content of the recording; `interval` (s) is null if the file states its times. @typedef {{readonly id: number, readonly name: string, readonly bytes: Uint8Array, readonly program: number | null, readonly used: boolean, readonly interval: number | null}} GivenRecording */

/**
 * @typedef {object} DocumentOfPrograms
 * @property {readonly GivenProgram[]} programs  the operations of the job, in order
 * @property {number | null} selected  the program in sight
 * @property {readonly GivenRecording[]} recordings
 * @property {number | null} recording  the one in sight
 * @property {string} start  the machine to begin with, by its name
 * @property {Values} values  of the machine
 * @property {readonly Preset[]} kept  machines that are kept in the browser
 * @property {readonly number[]} tolerances  mm, ascending
 * @property {boolean} programmed  the program's own tolerances are shown
 * @property {string} quoted  what the tolerance of the price is called; empty: the first
 * @property {Values} terms  of the price
 * @property {string} lengthUnit  the word of the unit in which lengths are shown
 * @property {string | null} beside  the machine compared with, by its name
 * @property {Calibration | null} calibration
 * @property {Before | null} sample  what was in the form before the demo's machine
 * @property {Before | null} beforeSettings  what settings from a link or file took the place of
 */

/** @typedef {DocumentOfPrograms & Readonly<OfJob>} Document */

/** What is in sight is no change of its own; it comes back with a change where what is in sight has gone. */
const SEEN = ['selected', 'recording']
/** Whose entries are typed. */
const FORMS = ['values', 'terms', 'letter', 'company']

/** Changes of one entry that follow each other faster are one: somebody types. */
const TYPING_MS = 1500
const MOST = 200

export class History {
  /** @type {Document[]} */
  #past = []
  /** @type {Document[]} */
  #future = []
  #changed = ''
  #at = -Infinity

  /** Counts every change, made, taken back or made again. */
  version = 0

  /** @param {Document} now */
  constructor(now) {
    this.now = now
  }

  /** Takes note of what there is now. @param {Document} next */
  note(next) {
    const changed = difference(this.now, next)
    const before = this.now
    this.now = next
    if (changed === '') return
    const time = performance.now()
    const isTyped = changed === this.#changed && changed.startsWith('typed ') && time - this.#at < TYPING_MS
    if (!isTyped) this.#past.push(before)
    if (this.#past.length > MOST) this.#past.shift()
    this.#future = []
    this.#changed = changed
    this.#at = time
    this.version += 1
  }

  /** Goes back to before the last change. */
  undo() {
    this.#move(this.#past, this.#future)
  }

  /** Makes the change again that was last taken back. */
  redo() {
    this.#move(this.#future, this.#past)
  }

  get canUndo() {
    return this.#past.length > 0
  }

  get canRedo() {
    return this.#future.length > 0
  }

  /** @param {Document[]} from @param {Document[]} to */
  #move(from, to) {
    const found = from.pop()
    if (!found) return
    to.push(this.now)
    this.now = { ...found, ...stillThere(this.now, found) }
    this.#changed = ''
    this.version += 1
  }
}

/** What is in sight after a step: what the step brings back, else what was, as far as it is there. @param {Document} before @param {Document} next */
function stillThere(before, next) {
  const isThere = (/** @type {readonly {id: number}[]} */ all, /** @type {number | null} */ wanted) => all.some(({ id }) => id === wanted)
  const first = isThere(next.programs, next.selected) ? next.selected : (next.programs[0]?.id ?? null)
  const isBack = isThere(next.programs, next.selected) && !isThere(before.programs, next.selected)
  return {
    selected: !isBack && isThere(next.programs, before.selected) ? before.selected : first,
    recording: isThere(next.recordings, before.recording) ? before.recording : next.recording,
  }
}

/** What differs, by name; one entry of a form is something typed. @param {Document} a @param {Document} b */
function difference(a, b) {
  /** @param {any} x @param {any} y */
  const same = (x, y) => x === y || (Array.isArray(x) && Array.isArray(y) && x.length === y.length && x.every((one, index) => one === y[index]))
  const entries = /** @type {("values" | "terms" | "letter" | "company")[]} */ (FORMS).flatMap((form) =>
    a[form] === b[form]
      ? []
      : [...new Set([...Object.keys(a[form]), ...Object.keys(b[form])])].filter((key) => JSON.stringify(a[form][key]) !== JSON.stringify(b[form][key])).map((key) => `${form}.${key}`),
  )
  const others = /** @type {(keyof Document)[]} */ (Object.keys(b)).filter((key) => !SEEN.includes(key) && !FORMS.includes(key) && !same(a[key], b[key]))
  if (others.length === 0 && entries.length === 1) return `typed ${entries[0]}`
  const own = others.length === 1 && others[0] === 'programs' && entries.length === 0 ? typedIn(a.programs, b.programs) : undefined
  return own ?? [...others, ...entries].join(' ')
}

/** A number that is typed for one operation; nothing where something else has changed. @param {readonly GivenProgram[]} before @param {readonly GivenProgram[]} after */
function typedIn(before, after) {
  if (before.length !== after.length) return undefined
  const changed = after.flatMap((one, index) => (one === before[index] ? [] : [{ one, former: before[index] }]))
  if (changed.length !== 1 || changed[0].one.id !== changed[0].former.id) return undefined
  const [{ one, former }] = changed
  const keys = /** @type {(keyof GivenProgram)[]} */ (Object.keys(one)).filter((key) => one[key] !== former[key])
  const isTyped = keys.length === 1 && ['setUp', 'loading'].includes(keys[0])
  return isTyped ? `typed ${[one.id, ...keys].join('.')}` : undefined
}
