// Files that the browser keeps, brought to memory: Firefox can no longer read a file of a record of its database once that record is
// written again, though it be with the same file.

/** What is larger is left where it is: to read it takes longer than a page may take to begin. Bytes. */
const MOST = 100_000_000

/** Programs with their files in memory. @template {{file: Blob}} P @param {readonly P[]} programs @returns {Promise<P[]>} */
export function inMemory(programs) {
  const copied = async (/** @type {P} */ program) => (program.file.size <= MOST ? { ...program, file: new Blob([await program.file.arrayBuffer()]) } : program)
  return Promise.all(programs.map(copied))
}
