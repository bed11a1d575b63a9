// Lines of a program by their number, looked up in its file: the whole text is never held here.

/** So many lines lie between two places that are kept. */
const EVERY = 4096

/**
 * Gives a line of a program, or an empty text where there is none. The file is gone through once, when a line is first asked for.
 * @param {Blob} file
 * @returns {(line: number) => Promise<string>}
 */
export function linesOf(file) {
  /** @type {Promise<number[]> | undefined} */
  let places
  return async (line) => {
    const starts = await (places ??= placesOf(file))
    const index = Math.floor((line - 1) / EVERY)
    const text = await file.slice(starts[index], starts[index + 1]).text()
    return text.split(/\r\n|\n|\r/)[(line - 1) % EVERY] ?? ''
  }
}

/** Where the first line, and each one EVERY lines further, begins, bytes; and the end. @param {Blob} file */
async function placesOf(file) {
  const starts = [0]
  const reader = file.stream().getReader()
  let [at, lines, wasReturn] = [0, 0, false]
  for (let piece = await reader.read(); piece.value; piece = await reader.read()) {
    for (const byte of piece.value) {
      at += 1
      if (byte === 10 && wasReturn) {
        // It belongs to the end of line that was counted already.
        if (lines % EVERY === 0) starts[starts.length - 1] = at
      } else if (byte === 10 || byte === 13) {
        lines += 1
        if (lines % EVERY === 0) starts.push(at)
      }
      wasReturn = byte === 13
    }
  }
  return [...starts, at]
}
