// The document and what has been computed from it, as the one state that the panels are shown. What belongs to a program or a
// recording that is no longer in the document is let go at once: taking its removal back computes it again.

import { faults, motionOf, termFaults } from '../pkg/truefeed.js'
import { headOf } from '../job/names.js'
import { linesOf } from '../lines.js'
import { programFor } from '../recordings.js'
import { History } from './history.js'

/** @import { OwnMachine } from "../job/document.js" */
/** @import { Document, GivenProgram, GivenRecording } from "./history.js" */
/** @import { Form, MachineForm, Parameter, Preset, Program, Recording, State, Values } from "../types.js" */

/** A change that can be taken back as long as it is the last one. @typedef {{isLast: () => boolean, undo: () => void}} Step */

/** What is not in the document: it is computed, or passes. @typedef {Pick<State, "calibrating" | "diagnosis" | "diagnosing" | "cut" | "revised" | "price" | "progress" | "paused">} Passing */

export class Store {
  /** @type {Map<number, Program>} */
  #programs = new Map()
  /** @type {Map<number, Recording>} */
  #recordings = new Map()
  /** What the forms were last filled with. @type {Partial<Document>} */
  #filled = {}

  /**
   * @param {Document} document
   * @param {Form} form  its machines to begin with become those of the document
   * @param {Parameter[]} termFields
   * @param {(before: Document, motion: string | undefined) => void} heard  after each change, with the document and the machine before it
   */
  constructor(document, form, termFields, heard) {
    this.form = form
    this.presets = form.presets
    this.termFields = termFields
    this.history = new History(document)
    this.heard = heard
    /** @type {Passing} */
    const passing = { calibrating: false, diagnosis: null, diagnosing: false, cut: null, revised: null, price: null, progress: null, paused: false }
    this.state = /** @type {State} */ (passing)
    this.#show()
  }

  /** All that a user has changed, as it is now. */
  get now() {
    return this.history.now
  }

  /** Changes the document. @param {Partial<Document>} what @returns {Step} */
  change(what) {
    this.#heard(() => this.history.note({ ...this.now, ...what }))
    const { version } = this.history
    const isLast = () => this.history.version === version
    return { isLast, undo: () => isLast() && this.undo() }
  }

  /** Takes the last change back. */
  undo() {
    this.#heard(() => this.history.undo())
  }

  /** Makes the change that was taken back again. */
  redo() {
    this.#heard(() => this.history.redo())
  }

  /** @param {() => unknown} move */
  #heard(move) {
    const [before, { motion }] = [this.now, this.state.machine]
    move()
    this.#show()
    this.heard(before, motion)
  }

  /** Brings the state up to the document. */
  #show() {
    const { now, state } = this
    const { tolerances, programmed, quoted, selected, recording, calibration, sample, beforeSettings, lengthUnit, job, fixture, letter, company } = now
    this.form.presets = [...this.presets, ...now.kept]
    state.programs = entries(this.#programs, now.programs, programOf)
    state.recordings = entries(this.#recordings, now.recordings, (given, before) => recordingOf(given, before, now))
    Object.assign(state, { tolerances: [...tolerances], programmed, quoted, selected, recording, calibration, sample, beforeSettings, lengthUnit, job, fixture, letter, company })
    state.beside = now.beside === null ? null : this.#preset(now.beside)
    const preset = this.#preset(now.start) ?? 0
    if (now.values !== this.#filled.values || preset !== state.machine?.preset) state.machine = filled(preset, now.values)
    if (now.terms !== this.#filled.terms) state.terms = filledTerms(this.termFields, now.terms)
    this.#filled = now
  }

  /** Which machine to begin with has this name; null where none has. @param {string} name */
  #preset(name) {
    const index = this.form.presets.findIndex((preset) => preset.name === name)
    return index < 0 ? null : index
  }
}

/** What is shown for each that is given, kept as long as it is given. @template {{id: number}} Given @template {{id: number}} Shown @param {Map<number, Shown>} all @param {readonly Given[]} given @param {(given: Given, before: Shown | undefined) => Shown} show */
function entries(all, given, show) {
  const shown = given.map((one) => show(one, all.get(one.id)))
  all.clear()
  for (const one of shown) all.set(one.id, one)
  return shown
}

/** A program with its results; read otherwise, nothing of the former reading holds. @param {GivenProgram} given @param {Program | undefined} before @returns {Program} */
function programOf({ id, name, file, dialect, title, machine, tolerance, setUp, loading }, before) {
  const own = { name, title, machine: machine && ownForm(machine), tolerance, setUp, loading }
  if (before && before.file === file) {
    if (before.dialect !== dialect) Object.assign(before, { dialect, outcome: null, failure: null })
    return Object.assign(before, own)
  }
  return { id, file, dialect, lines: linesOf(file), ...headOf(file), outcome: null, failure: null, ...own }
}

/** The forms of machines that operations have of their own. @type {WeakMap<OwnMachine, MachineForm & {start: string}>} */
const ownForms = new WeakMap()

/** @param {OwnMachine} machine */
function ownForm(machine) {
  const form = ownForms.get(machine) ?? { start: machine.start, ...filled(-1, machine.values) }
  ownForms.set(machine, form)
  return form
}

/** A recording with its comparison; with another program, or one read otherwise, there is none yet. @param {GivenRecording} given @param {Recording | undefined} before @param {Document} now @returns {Recording} */
function recordingOf({ id, name, bytes, program: chosen, used, interval }, before, { programs }) {
  // Read at another interval, it may be of another program.
  const previous = before?.interval === interval ? before : undefined
  const program = programFor(chosen, previous, programs)
  const dialect = programs.find((one) => one.id === program)?.dialect
  const isCompared = previous && previous.program === program && previous.dialect === dialect
  const compared = isCompared ? { match: previous.match, failure: previous.failure } : { match: null, failure: null }
  return Object.assign(before ?? {}, { id, name, bytes, chosen, program, found: previous?.found ?? null, used, interval, dialect, ...compared })
}

/** The form with what Rust says about it. @param {number} preset @param {Values} values @returns {MachineForm} */
function filled(preset, values) {
  const json = JSON.stringify(values)
  return { preset, values, faults: JSON.parse(faults(json)), motion: motionOf(json) }
}

/** The terms of the price with what Rust says about them. @param {Parameter[]} fields @param {Values} given @returns {State["terms"]} */
function filledTerms(fields, given) {
  const values = Object.fromEntries(fields.map(({ key, neutral }) => [key, key in given ? given[key] : neutral]))
  return { values, faults: JSON.parse(termFaults(JSON.stringify(values))) }
}
