// Jobs that are kept in the browser, each with its programs, until they are removed. No tab owns them.

const DATABASE = 'truefeed.jobs'
const STORE = 'jobs'

/** A job as it is kept: its text, its programs by their names in it, and what the list says of it. @typedef {{id: string, name: string, saved: number, about: string, customer: string, text: string, programs: {name: string, file: Blob}[]}} KeptJob */

/** @returns {Promise<IDBDatabase>} */
function open() {
  return new Promise((resolve, reject) => {
    const asked = indexedDB.open(DATABASE, 1)
    asked.onupgradeneeded = () => asked.result.createObjectStore(STORE, { keyPath: 'id' })
    asked.onsuccess = () => resolve(asked.result)
    asked.onerror = () => reject(asked.error)
  })
}

/** @template T @param {IDBTransactionMode} mode @param {(store: IDBObjectStore) => IDBRequest<T>} ask @returns {Promise<T>} */
async function asked(mode, ask) {
  const database = await open()
  try {
    return await new Promise((resolve, reject) => {
      const transaction = database.transaction(STORE, mode)
      const request = ask(transaction.objectStore(STORE))
      // What was written is there when the transaction is through.
      transaction.oncomplete = () => resolve(request.result)
      transaction.onabort = () => reject(transaction.error)
    })
  } finally {
    database.close()
  }
}

/** Keeps a job, in the place of the one with its id. @param {KeptJob} job */
export const keep = (job) => asked('readwrite', (store) => store.put(job))

/** @param {string} id @returns {Promise<KeptJob | undefined>} */
export const jobOf = (id) => asked('readonly', (store) => store.get(id))

/** @param {string} id */
export const remove = (id) => asked('readwrite', (store) => store.delete(id))

/** All that are kept, the last first. @returns {Promise<KeptJob[]>} */
export async function all() {
  const jobs = await asked('readonly', (store) => store.getAll())
  return jobs.sort((a, b) => b.saved - a.saved)
}

/** Those in whose name, customer, programs or remarks every word that is looked for stands. @param {readonly KeptJob[]} jobs @param {string} wanted */
export function found(jobs, wanted) {
  const words = wanted.toLowerCase().split(/\s+/).filter(Boolean)
  return jobs.filter(({ name, customer, about, programs }) => {
    const text = [name, customer, about, ...programs.map((program) => program.name)].join('\n').toLowerCase()
    return words.every((word) => text.includes(word))
  })
}
