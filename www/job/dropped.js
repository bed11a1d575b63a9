// What is dropped or chosen: files, those in folders and those in archives, in the order of their names.

/** So many files of folders and archives are looked at; a job has no more operations. */
export const MOST_FILES = 200

/** A file with the folders that it was found in; `named`: it was dropped itself, and not a folder or archive that it is in. @typedef {{file: File, path: string, named: boolean}} Found */

/** op2 comes before op10. */
const order = new Intl.Collator('en', { numeric: true, sensitivity: 'base' })

/** What systems put beside files, and what is hidden. @param {string} path */
const isHidden = (path) => path.split('/').some((name) => name.startsWith('.') || name === '__MACOSX' || name === 'Thumbs.db' || name === 'desktop.ini')

/** The files of a drop, those of its folders too. @param {readonly {entry: FileSystemEntry | null, file: File | null}[]} dropped @returns {Promise<Found[]>} */
export async function filesOf(dropped) {
  /** @type {Found[]} */
  const found = []
  for (const { entry, file } of dropped) {
    if (entry?.isDirectory) await walk(/** @type {FileSystemDirectoryEntry} */ (entry), found)
    else if (file) found.push({ file, path: file.name, named: true })
  }
  return inOrder(found)
}

/** The files of an input, of files or of a folder. @param {Iterable<File>} files */
export function chosen(files) {
  const found = [...files].map((file) => ({ file, path: file.webkitRelativePath || file.name, named: !file.webkitRelativePath }))
  return inOrder(found.filter(({ path, named }) => named || !isHidden(path)).slice(0, MOST_FILES))
}

/** The files of an archive. @param {string} archive  its name @param {{names(): string[], take(index: number): Uint8Array}} unpacked @returns {Found[]} */
export function inside(archive, unpacked) {
  const names = unpacked.names().map((path, index) => ({ path, index }))
  const taken = names.filter(({ path }) => !isHidden(path)).slice(0, MOST_FILES)
  return inOrder(
    taken.map(({ path, index }) => ({
      file: new File([/** @type {BlobPart} */ (unpacked.take(index))], path.split('/').pop() ?? path),
      path: `${archive}/${path}`,
      named: false,
    })),
  )
}

/** @param {Found[]} found */
const inOrder = (found) => [...found].sort((a, b) => order.compare(a.path, b.path))

/** Goes through a folder and those in it. @param {FileSystemDirectoryEntry} folder @param {Found[]} found */
async function walk(folder, found) {
  const reader = folder.createReader()
  for (;;) {
    /** A browser hands out a hundred at a time. @type {FileSystemEntry[]} */
    const entries = await new Promise((resolve, reject) => reader.readEntries(resolve, reject))
    if (entries.length === 0 || found.length >= MOST_FILES) return
    for (const entry of entries) {
      const path = entry.fullPath.replace(/^\//, '')
      if (found.length >= MOST_FILES) return
      if (isHidden(entry.name)) continue
      if (entry.isDirectory) await walk(/** @type {FileSystemDirectoryEntry} */ (entry), found)
      else found.push({ file: await fileOf(/** @type {FileSystemFileEntry} */ (entry)), path, named: false })
    }
  }
}

/** @param {FileSystemFileEntry} entry @returns {Promise<File>} */
const fileOf = (entry) => new Promise((resolve, reject) => entry.file(resolve, reject))
