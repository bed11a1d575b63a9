// What panels may ask of the job around the programs: each answer is a new document.

import { nothing } from '../job/document.js'
import { moved } from '../job/order.js'
import { freeName } from '../machines.js'
import { plain } from './programs.js'

/** @import { OfJob, OfOperation } from "../job/document.js" */
/** @import { Value, Values } from "../types.js" */
/** @import { GivenProgram } from "./history.js" */
/** @import { Store } from "./store.js" */

/** An operation with its program, as it comes from a file, from what is kept or from the samples. @typedef {Partial<OfOperation> & {name: string, dialect?: string | null, file: Blob}} NewOperation */

/** @param {Store} store @param {{nextId(): number, hurry(): void}} page */
export function jobActions(store, page) {
  /** @param {readonly NewOperation[]} operations */
  function given(operations) {
    /** @type {GivenProgram[]} */
    const all = []
    for (const { name, file, dialect = null, ...own } of operations) {
      all.push({ ...plain(), ...own, id: page.nextId(), name: freeName(name, all), file, dialect })
    }
    return all
  }

  return {
    /** Changes what an operation has of its own. @param {number} id @param {Partial<OfOperation>} what */
    setOperation(id, what) {
      const programs = store.now.programs.map((one) => (one.id === id ? { ...one, ...what } : one))
      return store.change({ programs })
    },
    /** Puts an operation at another place. @param {number} id @param {number} to  its place afterwards */
    moveProgram(id, to) {
      const from = store.now.programs.findIndex((one) => one.id === id)
      const programs = moved(store.now.programs, from, to)
      if (programs !== store.now.programs) store.change({ programs })
    },
    /** Changes what the job has beside its operations. @param {Partial<OfJob>} what */
    setJob(what) {
      store.change(what)
    },
    /** Changes one entry of the letter. @param {string} key @param {Value} value */
    setLetter(key, value) {
      store.change({ letter: { ...store.now.letter, [key]: value } })
    },
    /** Changes one entry of the company's profile. @param {string} key @param {Value} value */
    setCompany(key, value) {
      store.change({ company: { ...store.now.company, [key]: value } })
    },
    /** Takes the place of all that is open. What a job does not say stays as it is. @param {Partial<OfJob> & {operations: readonly NewOperation[], values?: Values, terms?: Values, tolerances?: readonly number[], programmed?: boolean, quoted?: string}} job */
    openJob({ operations, ...job }) {
      const programs = given(operations)
      const { company } = store.now
      const profile = job.company && Object.keys(job.company).length > 0 ? job.company : company
      store.change({ ...nothing(), ...job, company: profile, programs, selected: programs[0]?.id ?? null, recordings: [], recording: null })
      page.hurry()
    },
    /** Begins a job without programs; machine, tolerances, rates and the company stay. */
    newJob() {
      const { company } = store.now
      store.change({ ...nothing(), company, programs: [], selected: null, recordings: [], recording: null })
    },
  }
}
