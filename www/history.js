// What the user changed, step by step, so that every change can be taken back and made again.

/**
 * What a user changes. Results hang on the programs, which are kept as they are.
 * @typedef {object} Snapshot
 * @property {readonly import("./types.js").Program[]} programs
 * @property {number | null} selected
 * @property {readonly import("./types.js").Recording[]} recordings
 * @property {number} preset
 * @property {import("./types.js").Values} values  of the machine
 * @property {readonly number[]} tolerances
 * @property {boolean} programmed
 * @property {import("./types.js").Values} terms  of the quote
 * @property {number | null} beside  the machine compared with
 */

/** Changes of one entry that follow each other faster are one: somebody types. */
const TYPING_MS = 1500
const MOST = 200

export class History {
  /** @type {Snapshot[]} */
  #past = []
  /** @type {Snapshot[]} */
  #future = []
  #changed = ''
  #at = -Infinity

  /** @param {Snapshot} now */
  constructor(now) {
    this.now = now
  }

  /** Takes note of what there is now, where that is something else. @param {Snapshot} next */
  note(next) {
    const changed = difference(this.now, next)
    if (changed === '') return
    const time = performance.now()
    const isTyped = changed === this.#changed && changed.startsWith('typed ') && time - this.#at < TYPING_MS
    if (!isTyped) this.#past.push(this.now)
    if (this.#past.length > MOST) this.#past.shift()
    this.#future = []
    this.#changed = changed
    this.#at = time
    this.now = next
  }

  /** The state before the last change. @returns {Snapshot | undefined} */
  undo() {
    return this.#move(this.#past, this.#future)
  }

  /** The state after the change that was last taken back. @returns {Snapshot | undefined} */
  redo() {
    return this.#move(this.#future, this.#past)
  }

  get canUndo() {
    return this.#past.length > 0
  }

  get canRedo() {
    return this.#future.length > 0
  }

  /** @param {Snapshot[]} from @param {Snapshot[]} to */
  #move(from, to) {
    const found = from.pop()
    if (!found) return undefined
    to.push(this.now)
    this.now = found
    this.#changed = ''
    return found
  }
}

/** What differs, by name; one entry of a form is something typed. @param {Snapshot} a @param {Snapshot} b */
function difference(a, b) {
  const forms = /** @type {const} */ (['values', 'terms'])
  const entries = forms.flatMap((form) =>
    [...new Set([...Object.keys(a[form]), ...Object.keys(b[form])])]
      .filter((key) => JSON.stringify(a[form][key]) !== JSON.stringify(b[form][key]))
      .map((key) => `${form}.${key}`),
  )
  const same = (/** @type {readonly unknown[]} */ x, /** @type {readonly unknown[]} */ y) =>
    x.length === y.length && x.every((one, index) => one === y[index])
  const lists = /** @type {const} */ (['programs', 'recordings', 'tolerances']).filter((key) => !same(a[key], b[key]))
  const single = /** @type {const} */ (['preset', 'programmed', 'beside']).filter((key) => a[key] !== b[key])
  const others = [...lists, ...single]
  return others.length === 0 && entries.length === 1 ? `typed ${entries[0]}` : [...others, ...entries].join(' ')
}
