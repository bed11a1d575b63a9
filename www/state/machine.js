// What panels may ask of the machine, of those that are kept, of tolerances, terms and settings: each answer is a new document.

import { edited, motionOf, mostCurves, toleranceLabel } from '../pkg/truefeed.js'
import { columnKey, programInSight, quotedColumn } from '../columns.js'
import { freeName, keptMachine } from '../machines.js'
import { whole } from '../whole.js'

/** @import { Document } from "./history.js" */
/** @import { Store } from "./store.js" */
/** @import { Before, Calibration, Column, Value, Values } from "../types.js" */

/** A fitted tolerance is known to about a hundredth of itself. */
const FITTED_FIGURES = 3

/** @param {Store} store */
export function machineActions(store) {
  const presets = () => store.form.presets
  /** Of the name of the machine to begin with; the first where it is gone. @param {string | undefined} name */
  const known = (name) => (presets().find((preset) => preset.name === name) ?? presets()[0]).name

  /** What is in the form now. @returns {Before} */
  function inForm() {
    const { start, values, tolerances, quoted } = store.now
    return { start, values, tolerances: [...tolerances], quoted }
  }

  /** What was in the form, as a change. @param {Before} before @returns {Partial<Document>} */
  function back({ start, values, tolerances, quoted, programmed, terms, lengthUnit }) {
    return {
      start: known(start),
      values,
      tolerances,
      ...(quoted === undefined ? {} : { quoted }),
      ...(programmed === undefined ? {} : { programmed }),
      ...(terms ? { terms } : {}),
      ...(lengthUnit ? { lengthUnit } : {}),
    }
  }

  /** Keeps a machine under a name of its own and chooses it. @param {Values} values */
  function adopt(values) {
    const own = keptMachine({ ...values, name: freeName(String(values.name), presets()) })
    return store.change({ kept: [...store.now.kept, own], start: own.name, values: own.values })
  }

  const actions = {
    /** @param {number} index */
    choosePreset(index) {
      const { name, values } = presets()[index]
      store.change({ start: name, values: { ...values } })
    },
    /** @param {Values} values */
    setMachine(values) {
      return store.change({ values })
    },
    /** @param {string} key @param {Value} value */
    setParameter(key, value) {
      const values = edited(JSON.stringify(store.now.values), key, JSON.stringify(value))
      if (values) actions.setMachine(JSON.parse(values))
    },
    /** Keeps the machine of the form. */
    keepMachine() {
      const { kept, start, values, beside } = store.now
      const former = kept.find(({ name }) => name === start)
      if (!former) return adopt(values)
      const others = presets().filter((other) => other !== former)
      const own = keptMachine({ ...values, name: freeName(String(values.name), others) })
      return store.change({
        kept: kept.map((one) => (one === former ? own : one)),
        start: own.name,
        values: own.values,
        beside: beside === start ? own.name : beside,
      })
    },
    /** Keeps a copy of the machine of the form under another name. */
    duplicateMachine() {
      return adopt(store.now.values)
    },
    /** Keeps the machine of a file; throws what is wrong with it. @param {string} text */
    async importMachine(text) {
      const { valuesOfFile } = await whole()
      return adopt(JSON.parse(valuesOfFile(text)))
    },
    /** Takes the filters of one recorded move into the form; throws why there are none. @param {string} name @param {Uint8Array} recording */
    async takeMove(name, recording) {
      const { filtersOfMove } = await whole()
      const { sentence, values } = filtersOfMove(JSON.stringify(store.now.values), name, recording)
      return { sentence, step: actions.setMachine(values) }
    },
    /** Takes a kept machine out. */
    removeMachine() {
      const { kept, start, beside } = store.now
      const [{ name, values }] = presets()
      return store.change({ kept: kept.filter((one) => one.name !== start), start: name, values: { ...values }, beside: beside === start ? null : beside })
    },
    /** Shows another machine beside that of the form, or none. @param {number | null} preset */
    setBeside(preset) {
      store.change({ beside: preset === null ? null : presets()[preset].name })
    },
    /** @param {number[]} tolerances  mm */
    setTolerances(tolerances) {
      store.change({ tolerances: [...tolerances].sort((a, b) => a - b) })
    },
    /** Shows the program's own tolerances, or not. @param {boolean} programmed */
    setProgrammed(programmed) {
      store.change({ programmed })
    },
    /** Chooses the tolerance of the price: of the operation in sight where that has its own, else of the job. @param {Column} column */
    setQuoted(column) {
      const { programs, selected } = store.now
      const hasOwn = programs.some(({ id, tolerance }) => id === selected && tolerance !== null)
      const tolerance = column ?? 'programmed'
      if (hasOwn) return store.change({ programs: programs.map((one) => (one.id === selected ? { ...one, tolerance } : one)) })
      const { tolerances } = store.now
      const isCompared = column === null || tolerances.includes(column)
      return store.change({ quoted: columnKey(column), ...(isCompared ? {} : { tolerances: [...tolerances, column].sort((a, b) => a - b) }) })
    },
    /** Terms change no motion. @param {string} key @param {Value} value */
    setTerm(key, value) {
      store.change({ terms: { ...store.state.terms.values, [key]: value } })
    },
    /** Shows lengths in another unit. @param {string} lengthUnit */
    setLengthUnit(lengthUnit) {
      store.change({ lengthUnit })
    },
    /** The settings as text. */
    async settings() {
      const { settingsText } = await whole()
      const { values, tolerances, programmed, start, lengthUnit } = store.now
      const full = { truefeed: 1, preset: start, machine: values, tolerances_mm: tolerances, programmed, terms: store.state.terms.values, length_unit: lengthUnit }
      return settingsText(JSON.stringify(full))
    },
    /** Takes the settings of a text; throws why they are none. @param {string} text */
    async takeSettings(text) {
      const { settingsFromText } = await whole()
      const { preset, machine, tolerances_mm: tolerances, programmed, terms, length_unit: lengthUnit = store.form.lengths[0].word } = JSON.parse(settingsFromText(text))
      // Of several in a row, the user's own are those from before the first.
      const beforeSettings = store.now.beforeSettings ?? { ...inForm(), programmed: store.now.programmed, terms: store.state.terms.values, lengthUnit: store.now.lengthUnit }
      store.change({ ...back({ start: preset, values: machine, tolerances, programmed, terms, lengthUnit }), beforeSettings })
    },
    /** Takes the settings back that were there before. */
    undoSettings() {
      const { beforeSettings: before } = store.now
      if (before) store.change({ ...back(before), beforeSettings: null })
    },
    /** Stays with the settings from elsewhere. */
    forgetSettings() {
      store.change({ beforeSettings: null })
    },
    /** Takes the machine back that was there before the demo. */
    undoSample() {
      const { sample } = store.now
      if (sample) store.change({ ...back(sample), sample: null })
    },
    /** Puts a calibrated machine in the form, and quotes its tolerance, at which its error is known. @param {Calibration} calibration */
    take(calibration) {
      const { values, tolerance_mm: fitted } = calibration.report
      const tolerance = Number(fitted.toPrecision(FITTED_FIGURES))
      const label = toleranceLabel(tolerance)
      const others = store.now.tolerances.filter((other) => toleranceLabel(other) !== label)
      const tolerances = [...others.slice(0, mostCurves() - 2), tolerance].sort((a, b) => a - b)
      // Who quotes what the program sets goes on to.
      const quoted = columnKey(quotedColumn(store.state, programInSight(store.state)) === null ? null : tolerance)
      store.change({ calibration, tolerances, quoted, values })
    },
    /** Takes the machine back that was there before the calibration. */
    undoCalibration() {
      const { calibration } = store.now
      if (calibration) store.change({ ...back(calibration.before), calibration: null })
    },
    /** Puts the machine with the causes in the form. */
    useDiagnosis() {
      const { diagnosis } = store.state
      if (!diagnosis?.report.values) return
      store.state.diagnosis = { ...diagnosis, used: true, before: inForm() }
      actions.setMachine(diagnosis.report.values)
    },
    /** Takes the machine back that was there before. */
    undoDiagnosis() {
      const { diagnosis } = store.state
      if (!diagnosis) return
      store.state.diagnosis = { ...diagnosis, used: false }
      store.change(back(diagnosis.before))
    },
    /** Puts values that were tried in the form. @param {Values} values */
    tryValues(values) {
      const { diagnosis } = store.state
      if (!diagnosis) return
      // The machine that is tried is of the diagnosis too.
      const motions = [...diagnosis.motions, motionOf(JSON.stringify(values))]
      store.state.diagnosis = { ...diagnosis, motions, used: true, before: diagnosis.used ? diagnosis.before : inForm() }
      actions.setMachine(values)
    },
  }
  return { ...actions, inForm }
}
