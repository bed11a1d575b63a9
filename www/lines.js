// Lines of a program by their number, looked up in its file: the whole text is never held here.

/** So many lines are read at a time. */
const EVERY = 4096
/** So many readings are kept. */
const KEPT = 16
/** After so long the page gets its turn, ms. */
const TURN_MS = 6

/**
 * @typedef {object} Lines
 * @property {() => Promise<number>} count
 * @property {(line: number) => Promise<string>} at  an empty text where there is no such line
 * @property {(line: number) => string | undefined} known  the same at once, where it was read not long ago
 */

/**
 * The lines of a file, which is gone through once, when one is first asked for.
 * @param {Blob} file
 * @returns {Lines}
 */
export function linesOf(file) {
  /** @type {Promise<{starts: number[], count: number}> | undefined} */
  let places
  /** @type {Map<number, string[]>} */
  const kept = new Map()
  const groupOf = (/** @type {number} */ line) => Math.floor((line - 1) / EVERY)
  return {
    count: async () => (await (places ??= placesOf(file))).count,
    known: (line) => kept.get(groupOf(line))?.[(line - 1) % EVERY],
    async at(line) {
      const { starts } = await (places ??= placesOf(file))
      const group = groupOf(line)
      const lines = kept.get(group) ?? textOf(await file.slice(starts[group], starts[group + 1]).arrayBuffer()).split(/\r\n|\n|\r/)
      kept.delete(group)
      kept.set(group, lines)
      for (const oldest of kept.keys()) if (kept.size > KEPT) kept.delete(oldest)
      return lines[(line - 1) % EVERY] ?? ''
    },
  }
}

/** A text in UTF-8, or else in the code page of older controls. @param {ArrayBuffer} bytes */
function textOf(bytes) {
  try {
    return new TextDecoder('utf-8', { fatal: true }).decode(bytes)
  } catch {
    return new TextDecoder('windows-1252').decode(bytes)
  }
}

/** Where the first line, and each one EVERY lines further, begins, bytes; the end; and how many lines there are. @param {Blob} file */
async function placesOf(file) {
  const starts = [0]
  const reader = file.stream().getReader()
  let [at, ends, wasReturn] = [0, 0, false]
  let begun = performance.now()
  for (let piece = await reader.read(); piece.value; piece = await reader.read()) {
    // Pieces that are there already would follow one another in a single task.
    if (performance.now() - begun > TURN_MS) {
      await new Promise((done) => setTimeout(done))
      begun = performance.now()
    }
    // By index, which is ten times as fast as by its iterator.
    for (let index = 0; index < piece.value.length; index += 1) {
      const byte = piece.value[index]
      at += 1
      if (byte === 10 && wasReturn) {
        // It belongs to the end of line that was counted already.
        if (ends % EVERY === 0) starts[starts.length - 1] = at
      } else if (byte === 10 || byte === 13) {
        ends += 1
        if (ends % EVERY === 0) starts.push(at)
      }
      wasReturn = byte === 13
    }
  }
  return { starts: [...starts, at], count: ends + 1 }
}
