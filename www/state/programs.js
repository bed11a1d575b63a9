// What panels may ask of programs and recordings: each answer is a new document.

import { freeName } from '../machines.js'

/** @import { OfOperation } from "../job/document.js" */
/** @import { GivenProgram, GivenRecording } from "./history.js" */
/** @import { Store } from "./store.js" */

/** What a program has of its own where nobody has said anything. @returns {OfOperation} */
export const plain = () => ({ title: '', machine: null, tolerance: null, setUp: null, loading: null })

/** @param {Store} store @param {{reveal(): void, hurry(): void}} page  what is done beside: a recording comes in sight, work begins at once */
export function programActions(store, page) {
  let nextId = Math.max(0, ...[...store.now.programs, ...store.now.recordings].map(({ id }) => id)) + 1

  /** Programs as they are given, under names of their own. @param {{name: string, file: Blob}[]} files */
  function given(files) {
    /** @type {GivenProgram[]} */
    const all = [...store.now.programs]
    for (const { name, file } of files) all.push({ ...plain(), id: nextId++, name: freeName(name, all), file, dialect: null })
    return all
  }

  /** Recordings as they are given, of a program or of one that is to be found. @param {{name: string, bytes: Uint8Array}[]} files @param {number | null} program */
  function recorded(files, program) {
    /** @type {GivenRecording[]} */
    const all = [...store.now.recordings]
    for (const { name, bytes } of files) all.push({ id: nextId++, name: freeName(name, all), bytes, program, used: true, interval: null })
    return all
  }

  /** The program in sight when recordings came, from which nobody has gone elsewhere yet. @type {number | null} */
  let awaiting = null

  /** One recording or program otherwise. @template {{id: number}} T @param {readonly T[]} all @param {number} id @param {Partial<T>} what */
  const otherwise = (all, id, what) => all.map((one) => (one.id === id ? { ...one, ...what } : one))

  /** What is left of a list, and what is in sight instead of what was taken out. @template {{id: number}} T @param {readonly T[]} all @param {number} id */
  function without(all, id) {
    const index = all.findIndex((one) => one.id === id)
    return { rest: all.filter((one) => one.id !== id), next: (all[index + 1] ?? all[index - 1])?.id ?? null }
  }

  const actions = {
    /** A number that no program and no recording has. */
    nextId: () => nextId++,
    /** @param {{name: string, file: Blob}[]} files @param {string} [called]  what the job is called, where it has no name yet */
    addPrograms(files, called = '') {
      const programs = given(files)
      const job = store.now.job || store.now.programs.length > 0 ? store.now.job : called
      const selected = programs[store.now.programs.length]?.id ?? store.now.selected
      store.change({ programs, selected, job })
      // Nobody types: there is nothing to wait for.
      page.hurry()
    },
    /** @param {{name: string, bytes: Uint8Array}[]} files */
    addRecordings(files) {
      const { selected, recordings: before } = store.now
      const recordings = recorded(files, null)
      awaiting = selected
      store.change({ recordings, recording: recordings[before.length].id })
      page.reveal()
    },
    /** It was found which program a recording is of, which comes in sight with it. @param {number} id @param {number | null} program */
    paired(id, program) {
      const { recording, selected } = store.now
      if (program !== null && recording === id && selected === awaiting) store.change({ selected: program })
    },
    /** A program, its machine and a recording of it, in one step. @param {import("../types.js").Values} values @param {{name: string, file: Blob}} program @param {{name: string, bytes: Uint8Array}} recording */
    addDemo(values, program, recording) {
      const { now } = store
      const programs = given([program])
      const selected = programs[programs.length - 1].id
      const recordings = recorded([recording], selected)
      const own = recordings[recordings.length - 1]
      const sample = now.sample ?? { start: now.start, values: now.values, tolerances: [...now.tolerances], quoted: now.quoted }
      store.change({ sample, values, programs, selected, recordings, recording: own.id })
      page.reveal()
      page.hurry()
    },
    /** @param {number} id */
    select(id) {
      store.change({ selected: id })
    },
    /** Shows a recording, and the program it is of. @param {number} id */
    selectRecording(id) {
      const program = store.state.recordings.find((one) => one.id === id)?.program
      const isThere = store.now.programs.some((one) => one.id === program)
      store.change({ recording: id, ...(isThere ? { selected: program ?? null } : {}) })
    },
    /** Says which program a recording is of. @param {number} id @param {number} program */
    setProgramOf(id, program) {
      store.change({ recordings: otherwise(store.now.recordings, id, { program }), recording: id, selected: program })
    },
    /** States the time between the rows of a recording whose file does not. @param {number} id @param {number} interval  s */
    setInterval(id, interval) {
      store.change({ recordings: otherwise(store.now.recordings, id, { interval }), recording: id })
    },
    /** Whether a recording is used to calibrate and to diagnose. @param {number} id @param {boolean} used */
    setUsed(id, used) {
      store.change({ recordings: otherwise(store.now.recordings, id, { used }) })
    },
    /** Takes a recording out. @param {number} id */
    removeRecording(id) {
      const { rest } = without(store.now.recordings, id)
      return store.change({ recordings: rest })
    },
    /** Takes a program out. @param {number} id */
    removeProgram(id) {
      const { programs, selected } = store.now
      const { rest, next } = without(programs, id)
      return store.change({ programs: rest, selected: selected === id ? next : selected })
    },
    /** Reads a program as another control would, or its arcs otherwise. @param {number} id @param {string | null} dialect */
    setDialect(id, dialect) {
      store.change({ programs: otherwise(store.now.programs, id, { dialect }) })
    },
  }
  return actions
}
