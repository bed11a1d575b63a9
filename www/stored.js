// What the browser has kept, checked by its shape: records of another version, changed by hand or cut short give way to defaults,
// so that the page starts whatever it finds. What a number may be is Rust's to say. Fetched where something is kept: a first
// visit does without.

import { STORE, answer, open, tab } from './kept.js'
import { inMemory } from './memory.js'
import { BEFORE, KEY } from './settings.js'

/** @import { Found, Kept } from "./kept.js" */
/** @import { Settings } from "./settings.js" */
/** @import { Before, Diagnosis, Form, Parameter, State, Value, Values } from "./types.js" */

/** The page does not wait longer for what it had open. */
const PATIENCE_MS = 3000

/** How long the browser may take to bring a closed tab back. */
const KEPT_MS = 24 * 3600 * 1000

/** @param {unknown} value @returns {value is Record<string, any>} */
const isRecord = (value) => typeof value === 'object' && value !== null && !Array.isArray(value)

/** A number as it is typed is a text until it is one, so that texts fit all fields but flags. @param {Parameter["kind"]} kind @param {unknown} value */
function fits(kind, value) {
  const isEntry = (/** @type {unknown} */ one) => typeof one === 'number' || typeof one === 'string'
  if (kind === 'flag') return typeof value === 'boolean'
  if (value === null || typeof value === 'string') return true
  if (kind === 'number') return typeof value === 'number'
  if (kind === 'list') return Array.isArray(value) && value.every(isEntry)
  return (kind === 'codes' || kind === 'tools') && isRecord(value) && Object.values(value).every(isEntry)
}

/** Those values of a form that its fields can show, by their keys. @param {Parameter[]} fields @param {Values} values @returns {Values} */
function fitted(fields, values) {
  const fitting = fields.filter(({ key, kind }) => Object.hasOwn(values, key) && fits(kind, values[key]))
  return Object.fromEntries(fitting.map(({ key }) => [key, /** @type {Value} */ (values[key])]))
}

/**
 * Settings without what has another shape than it should.
 * @param {unknown} kept
 * @param {Pick<Form, "fields" | "lengths">} form  of the machine
 * @param {Parameter[]} termFields  of the quote
 * @param {number} most  tolerances
 * @returns {any}
 */
function settingsIn(kept, { fields, lengths }, termFields, most) {
  if (!isRecord(kept)) return {}
  const { tolerances } = kept
  const areTolerances = Array.isArray(tolerances) && 0 < tolerances.length && tolerances.length < most && tolerances.every((one) => Number.isFinite(one) && 0 < one)
  const values = isRecord(kept.values) ? fitted(fields, kept.values) : {}
  const terms = isRecord(kept.terms) ? fitted(termFields, kept.terms) : {}
  const tests = /** @type {[string, unknown, boolean][]} */ ([
    ...['preset', 'beside', 'quoted', 'start'].map((key) => [key, kept[key], typeof kept[key] === 'string']),
    ['programmed', kept.programmed, typeof kept.programmed === 'boolean'],
    ['tolerances', tolerances, areTolerances],
    ['lengthUnit', kept.lengthUnit, lengths.some(({ word }) => word === kept.lengthUnit)],
    ['company', kept.company, isRecord(kept.company)],
    ['values', values, Object.keys(values).length > 0],
    ['terms', terms, Object.keys(terms).length > 0],
  ])
  return Object.fromEntries(tests.filter(([, , holds]) => holds).map(([key, value]) => [key, value]))
}

/** What is kept under a key; nothing where that is no JSON. @param {string} key @returns {unknown} */
function parsed(key) {
  try {
    return JSON.parse(localStorage.getItem(key) ?? 'null')
  } catch {
    return null
  }
}

/**
 * The settings of the last visit, and those from before settings came from elsewhere; of the machines kept in the form only what
 * its fields can show is left.
 * @param {Form} form
 * @param {Parameter[]} termFields
 * @param {number} most  tolerances
 * @returns {{settings: Settings, before: Before | null}}
 */
export function remembered(form, termFields, most) {
  for (const preset of form.presets) if (preset.kept) preset.values = fitted(form.fields, preset.values)
  const [settings, before] = [KEY, BEFORE].map((key) => settingsIn(parsed(key), form, termFields, most))
  return { settings, before: before.values && before.tolerances ? before : null }
}

/** Whether the files of a tab can be read. @param {any} record @returns {record is Kept} */
const isKept = (record) =>
  Array.isArray(record?.programs) &&
  record.programs.every((/** @type {any} */ one) => typeof one?.name === 'string' && one.file instanceof Blob) &&
  Array.isArray(record.recordings) &&
  record.recordings.every((/** @type {any} */ one) => typeof one?.name === 'string' && one.bytes instanceof Uint8Array)

/** What was found in a tab, but for what nobody could take back. @param {Kept} kept @returns {Found} */
function foundIn({ calibration, diagnosis, sample }) {
  const isBefore = (/** @type {any} */ one) => Array.isArray(one?.tolerances) && typeof one.values?.name === 'string'
  return {
    calibration: calibration?.report && isBefore(calibration.before) ? calibration : null,
    diagnosis: diagnosis?.report && Array.isArray(diagnosis.runs) && isBefore(diagnosis.before) ? diagnosis : null,
    sample: isBefore(sample) ? sample : null,
  }
}

/** @param {unknown} value */
const numberOr = (value) => (typeof value === 'number' ? value : null)

/** What belongs to a job, where it has the shape that it should. @param {any} found @returns {Pick<Kept, "job" | "fixture" | "letter" | "programs">} */
function jobIn({ job, fixture, letter, programs }) {
  const own = (/** @type {any} */ one) => ({
    ...one,
    title: String(one.title ?? ''),
    machine: typeof one.machine?.start === 'string' && isRecord(one.machine.values) ? one.machine : null,
    tolerance: one.tolerance === 'programmed' ? one.tolerance : numberOr(one.tolerance),
    setUp: numberOr(one.setUp),
    loading: numberOr(one.loading),
  })
  return { job: String(job ?? ''), fixture: numberOr(fixture), letter: isRecord(letter) ? letter : {}, programs: programs.map(own) }
}

/** What is kept under the name of a tab. @param {string} name @param {Kept} nothing @returns {Promise<Kept>} */
export function loadTab(name, nothing) {
  const patience = new Promise((resolve) => setTimeout(() => resolve(nothing), PATIENCE_MS))
  return Promise.race([read(name, nothing), /** @type {Promise<Kept>} */ (patience)])
}

/** @param {string} name @param {Kept} nothing @returns {Promise<Kept>} */
async function read(name, nothing) {
  const database = await open()
  const found = await answer(database.transaction(STORE).objectStore(STORE).get(name))
  database.close()
  if (!isKept(found)) return nothing
  const recordings = found.recordings.map((one) => ({ ...one, interval: numberOr(one.interval) }))
  return { ...nothing, ...found, recordings, ...foundIn(found), ...jobIn({ ...found, programs: await inMemory(found.programs) }) }
}

/** Deletes what closed tabs have left behind. */
export async function deleteClosed() {
  try {
    const { own } = await tab()
    const database = await open()
    const store = database.transaction(STORE, 'readwrite').objectStore(STORE)
    for (const key of await answer(store.getAllKeys())) {
      const other = key === own ? undefined : await answer(store.get(key))
      if (other && !(Date.now() - other.saved < KEPT_MS)) store.delete(key)
    }
    database.close()
  } catch {
    // A browser that keeps nothing has nothing to delete.
  }
}

/** The diagnosis that was kept, with the programs as they are now; none where one of them is gone. @param {Kept} kept @param {State} state @returns {Diagnosis | null} */
export function diagnosisOf({ diagnosis }, { programs }) {
  const runs = (diagnosis?.runs ?? []).flatMap((run) => {
    const program = programs.find(({ id }) => id === run?.program)
    return program ? [{ ...run, program }] : []
  })
  return diagnosis && runs.length === diagnosis.runs.length ? { ...diagnosis, runs } : null
}
