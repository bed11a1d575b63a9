// Starts the page: owns the one state object, has work done and tells the panels what changed.

import init, {
  arcCenters,
  dialects,
  edited,
  faults,
  form as formOfModule,
  mostCurves,
  motionOf,
  setNumbers,
  termFaults,
  termsForm,
  toleranceLabel,
  usualTolerances,
} from './pkg/truefeed.js'
import { isStill } from './columns.js'
import { confinedWorker } from './confined.js'
import { fillTexts } from './dom.js'
import { drawn } from './drawing.js'
import { firstModule, wholeModule } from './embed/module.js'
import { Engine } from './engine.js'
import { axis } from './format.js'
import { History } from './history.js'
import { linesOf } from './lines.js'
import { freeName, keptMachine, loadMachines, saveMachines } from './machines.js'
import * as chartPanel from './panels/chart.js'
import * as diagnosticsPanel from './panels/diagnostics.js'
import * as historyPanel from './panels/history.js'
import * as machinePanel from './panels/machine.js'
import * as programPanel from './panels/program.js'
import * as progressPanel from './panels/progress.js'
import * as recordingPanel from './panels/recording.js'
import * as resultsPanel from './panels/results.js'
import * as settingsPanel from './panels/settings.js'
import * as tolerancesPanel from './panels/tolerances.js'
import { pairs, recordingOf } from './recordings.js'
import { loadOpen, saveOpen } from './kept.js'
import { loadSettings, saveBefore, saveSettings } from './settings.js'
import { say } from './texts.js'
import { whole } from './whole.js'
import { workOn } from './work.js'

/** @import { Form, MachineForm, Place, Recording, State, Value, Values } from "./types.js" */

const DEBOUNCE_MS = 300

fillTexts(document)

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id))
const failure = element('failure')

/** Says what should never happen, rather than leaving a page that does nothing. @param {string} message */
function fail(message) {
  failure.textContent = say.work.fault(message)
  failure.hidden = false
}
window.addEventListener('error', ({ message }) => fail(say.work.wrong(message)))
window.addEventListener('unhandledrejection', ({ reason }) => fail(say.work.wrong(reason)))

const first = await firstModule()
await init({ module_or_path: first.module })
setNumbers(axis)
const engine = new Engine(first, confinedWorker, wholeModule)

/** @type {Form} */
const form = JSON.parse(formOfModule())
element('version').textContent = form.version
form.presets.push(...loadMachines())
/** @type {import("./types.js").Parameter[]} */
const termFields = JSON.parse(termsForm())
const { settings, before } = await loadSettings(form, termFields, mostCurves())
const opened = await loadOpen()

const knownPreset = startNamed(settings.preset)

/** @type {State} */
const state = {
  programs: opened.programs.map((kept) => ({ ...kept, lines: linesOf(kept.file), outcome: null, failure: null })),
  selected: opened.selected,
  programmed: settings.programmed ?? true,
  tolerances: settings.tolerances ?? [...usualTolerances()],
  machine: filled(knownPreset, { ...(settings.values ?? form.presets[knownPreset].values) }),
  terms: filledTerms(settings.terms ?? {}),
  beforeSettings: before,
  recordings: opened.recordings.map((kept) => ({ ...kept, match: null, failure: null })),
  recording: opened.recording,
  calibration: opened.calibration,
  calibrating: false,
  diagnosis: null,
  diagnosing: false,
  cut: null,
  sample: opened.sample,
  beside: presetNamed(settings.beside) ?? null,
  quoted: settings.quoted ?? '',
  progress: null,
  paused: false,
}

if (opened.diagnosis) state.diagnosis = (await import('./stored.js')).diagnosisOf(opened, state)
const history = new History(snapshot())
let nextId = Math.max(0, ...[...state.programs, ...state.recordings].map(({ id }) => id)) + 1
let timer = 0

/** What panels may ask for. */
export const actions = {
  /** @param {{name: string, file: Blob}[]} files */
  addPrograms(files) {
    for (const { name, file } of files) {
      state.programs.push({ id: nextId++, name: freeName(name, state.programs), file, lines: linesOf(file), dialect: null, outcome: null, failure: null })
    }
    const added = state.programs[state.programs.length - files.length]
    state.selected = added?.id ?? state.selected
    for (const recording of state.recordings) recording.program ??= pairs(recording.name, state)
    // Nobody types: there is nothing to wait for.
    changed(0)
  },
  /** @param {{name: string, bytes: Uint8Array}[]} files */
  addRecordings(files) {
    for (const { name, bytes } of files) {
      const program = pairs(name, state)
      state.recordings.push({ id: nextId++, name: freeName(name, state.recordings), bytes, program, used: true, match: null, failure: null })
    }
    actions.selectRecording(state.recordings[state.recordings.length - files.length].id)
    changed()
    recordings.reveal()
  },
  /** Shows a recording, and the program it is of. @param {number} id */
  selectRecording(id) {
    state.recording = id
    const program = state.recordings.find((recording) => recording.id === id)?.program
    if (state.programs.some((candidate) => candidate.id === program)) state.selected = program ?? null
    update()
  },
  /** Says which program a recording is of. @param {number} id @param {number} program */
  setProgramOf(id, program) {
    change(id, { program, match: null, failure: null })
    actions.selectRecording(id)
    changed()
  },
  /** Whether a recording is used to calibrate. @param {number} id @param {boolean} used */
  setUsed(id, used) {
    change(id, { used })
    update()
  },
  /** Takes a recording out; the function returned puts it back. @param {number} id */
  removeRecording(id) {
    const index = state.recordings.findIndex((recording) => recording.id === id)
    const [recording] = state.recordings.splice(index, 1)
    changed()
    return () => {
      state.recordings.splice(index, 0, recording)
      actions.selectRecording(id)
      changed()
    }
  },
  /** Calibrates the machine from all recordings that are used. */
  calibrate() {
    state.calibrating = true
    state.diagnosing = false
    engine.cancel()
    changed()
  },
  /** Takes the machine back that was there before the calibration. */
  undoCalibration() {
    if (!state.calibration) return
    const { before } = state.calibration
    state.calibration = null
    putBack(before)
  },
  /** Says what was left out of the machine, from all recordings that are used. */
  diagnose() {
    state.diagnosing = true
    state.calibrating = false
    engine.cancel()
    changed()
  },
  /** Puts the machine with the causes in the form. */
  useDiagnosis() {
    const { diagnosis } = state
    if (!diagnosis?.report.values) return
    state.diagnosis = { ...diagnosis, used: true, before: now() }
    actions.setMachine(state.machine.preset, diagnosis.report.values)
  },
  /** Takes the machine back that was there before. */
  undoDiagnosis() {
    if (!state.diagnosis) return
    const { before } = state.diagnosis
    state.diagnosis = { ...state.diagnosis, used: false }
    putBack(before)
  },
  /** Puts values that were tried in the form. @param {Values} values */
  tryValues(values) {
    if (!state.diagnosis) return
    const { diagnosis } = state
    // The machine that is tried is of the diagnosis too.
    const motions = [...diagnosis.motions, motionOf(JSON.stringify(values))]
    state.diagnosis = { ...diagnosis, motions, used: true, before: diagnosis.used ? diagnosis.before : now() }
    actions.setMachine(state.machine.preset, values)
  },
  /** A program, its machine and a recording in which something is concealed. @param {{machine: string, program: {name: string, file: Blob}, recording: {name: string, bytes: Uint8Array}}} sample */
  async addSample({ machine, program, recording }) {
    const { valuesOfFile } = await whole()
    state.sample ??= now()
    actions.setMachine(state.machine.preset, JSON.parse(valuesOfFile(machine)))
    actions.addPrograms([program])
    actions.addRecordings([recording])
    second().then(() => element('diagnosis').querySelector('button')?.focus())
  },
  /** Takes the machine back that was there before the sample. */
  undoSample() {
    if (!state.sample) return
    const before = state.sample
    state.sample = null
    putBack(before)
  },
  /** @param {number} id */
  select(id) {
    state.selected = id
    update()
  },
  /** Takes a program out; the function returned puts it back. @param {number} id */
  removeProgram(id) {
    const index = state.programs.findIndex((program) => program.id === id)
    const [program] = state.programs.splice(index, 1)
    const wasSelected = state.selected === id
    if (wasSelected) state.selected = (state.programs[index] ?? state.programs[index - 1])?.id ?? null
    if (state.progress?.program === id) engine.cancel()
    changed()
    return () => {
      state.programs.splice(index, 0, program)
      if (wasSelected) state.selected = id
      changed()
    }
  },
  /** Reads a program as another control would, or its arcs otherwise. @param {number} id @param {string | null} dialect */
  setDialect(id, dialect) {
    const program = state.programs.find((program) => program.id === id)
    if (!program || program.dialect === dialect) return
    program.dialect = dialect
    // Nothing of the former reading holds.
    program.outcome = null
    program.failure = null
    for (const recording of state.recordings) if (recording.program === id) recording.match = null
    if (state.progress?.program === id) engine.cancel()
    changed()
  },
  /** @param {number} index */
  choosePreset(index) {
    actions.setMachine(index, { ...form.presets[index].values })
  },
  /** @param {number} preset @param {Values} values */
  setMachine(preset, values) {
    const before = state.machine.motion
    state.machine = filled(preset, values)
    if (state.machine.motion !== before) engine.cancel()
    changed()
  },
  /** @param {string} key @param {Value} value */
  setParameter(key, value) {
    const values = edited(JSON.stringify(state.machine.values), key, JSON.stringify(value))
    if (values) actions.setMachine(state.machine.preset, JSON.parse(values))
  },
  /** Terms change no motion. @param {string} key @param {Value} value */
  setTerm(key, value) {
    state.terms = filledTerms({ ...state.terms.values, [key]: value })
    history.note(snapshot())
    remember()
    update()
  },
  /** Keeps the machine of the form; the function returned takes that back. */
  keepMachine() {
    const { preset, values } = state.machine
    const start = form.presets[preset]
    if (!start.kept) return adopt({ ...values, name: freeName(String(values.name), form.presets) })
    const others = form.presets.filter((other) => other !== start)
    return replaceKept(preset, keptMachine({ ...values, name: freeName(String(values.name), others) }))
  },
  /** Keeps a copy of the machine of the form under another name. */
  duplicateMachine() {
    const { values } = state.machine
    return adopt({ ...values, name: freeName(String(values.name), form.presets) })
  },
  /** Keeps the machine of a file; throws what is wrong with it. @param {string} text */
  async importMachine(text) {
    const { valuesOfFile } = await whole()
    const values = /** @type {Values} */ (JSON.parse(valuesOfFile(text)))
    return adopt({ ...values, name: freeName(String(values.name), form.presets) })
  },
  /** The same for a file that was dropped; the form says what is wrong with it. @param {File} file */
  addMachine(file) {
    return machine.take(file)
  },
  /** The same for settings. @param {File} file */
  addSettings(file) {
    return exchange.takeFile(file)
  },
  /** Says why something is not taken; nothing takes that back. @param {string} message */
  refuse(message) {
    exchange.refuse(message)
  },
  /** Takes a kept machine out; the function returned puts it back. */
  removeMachine() {
    const { preset } = state.machine
    const undo = replaceKept(preset, { ...form.presets[preset], removed: true })
    actions.choosePreset(0)
    return undo
  },
  /** The settings as text. */
  async settings() {
    const { settingsText } = await whole()
    const { machine, tolerances, programmed, terms } = state
    const preset = form.presets[machine.preset].name
    const full = { truefeed: 1, preset, machine: machine.values, tolerances_mm: tolerances, programmed, terms: terms.values }
    return settingsText(JSON.stringify(full))
  },
  /** Takes the settings of a text; throws why they are none. @param {string} text */
  async takeSettings(text) {
    const { settingsFromText } = await whole()
    const { preset, machine, tolerances_mm: tolerances, programmed, terms } = JSON.parse(settingsFromText(text))
    // Of several in a row, the user's own are those from before the first.
    state.beforeSettings ??= { ...now(), programmed: state.programmed, terms: state.terms.values, start: form.presets[state.machine.preset].name }
    saveBefore(state.beforeSettings)
    putBack({ preset: startNamed(preset), values: machine, tolerances, programmed, terms })
  },
  /** Takes the settings back that were there before. */
  undoSettings() {
    const before = state.beforeSettings
    actions.forgetSettings()
    if (before) putBack({ ...before, preset: startNamed(before.start) })
  },
  /** Stays with the settings from elsewhere. */
  forgetSettings() {
    state.beforeSettings = null
    saveBefore(null)
    update()
  },
  /** @param {Pick<Place, 'distance_mm'>} place */
  show(place) {
    second().then(({ path }) => path.keep(place.distance_mm))
    chart.show(place)
  },
  /** Shows a stretch of the path (mm) in the charts, where they are. @param {[number, number]} stretch */
  reveal(stretch) {
    chart.reveal(stretch)
  },
  /** What a cut asks of tool and spindle, for the breakdown. @param {import("./types.js").Cut | null} cut */
  setCut(cut) {
    if (cut === state.cut) return
    state.cut = cut
    update()
  },
  /** @param {number[]} tolerances  mm */
  setTolerances(tolerances) {
    state.tolerances = [...tolerances].sort((a, b) => a - b)
    changed()
  },
  /** Adds a tolerance that was pointed at, or says why not. @param {number} tolerance  mm */
  addTolerance(tolerance) {
    tolerances.choose(tolerance)
  },
  /** Shows another machine beside that of the form, or none. @param {number | null} preset */
  setBeside(preset) {
    state.beside = preset
    history.note(snapshot())
    remember()
    update()
  },
  /** Chooses the tolerance of the quote, by what it is called. @param {string} tolerance */
  setQuoted(tolerance) {
    state.quoted = tolerance
    remember()
    update()
  },
  /** Takes the last change back. */
  undo() {
    restore(history.undo())
  },
  /** Makes the change that was taken back again. */
  redo() {
    restore(history.redo())
  },
  /** Shows the program's own tolerances, or not. @param {boolean} shown */
  setProgrammed(shown) {
    state.programmed = shown
    changed()
  },
  cancel() {
    // Who stops a calibration or a diagnosis wants the machine as it is, and its results.
    if (state.calibrating || state.diagnosing) {
      state.calibrating = false
      state.diagnosing = false
      engine.cancel()
      return changed()
    }
    state.paused = true
    engine.cancel()
    update()
  },
  resume() {
    state.paused = false
    changed()
  },
}

/** All that a user changes, as it is now. @returns {import("./history.js").Snapshot} */
function snapshot() {
  const { programs, selected, recordings, machine, tolerances, programmed, terms, beside } = state
  const { preset, values } = machine
  return { programs: [...programs], selected, recordings: [...recordings], preset, values, tolerances, programmed, terms: terms.values, beside }
}

/** Puts all that a user changes back. @param {import("./history.js").Snapshot | undefined} all */
function restore(all) {
  if (!all) return
  const { preset, values } = all
  state.programs = [...all.programs]
  state.recordings = [...all.recordings]
  const isThere = (/** @type {number | null} */ id) => state.programs.some((program) => program.id === id)
  if (!isThere(state.selected)) state.selected = isThere(all.selected) ? all.selected : (state.programs[0]?.id ?? null)
  state.tolerances = [...all.tolerances]
  state.programmed = all.programmed
  state.terms = filledTerms(all.terms)
  state.beside = all.beside
  if (state.progress?.program && !isThere(state.progress.program)) engine.cancel()
  actions.setMachine(preset, values)
}

/** What is in the form now. @returns {import("./types.js").Before} */
const now = () => ({ preset: state.machine.preset, values: state.machine.values, tolerances: state.tolerances })

/** Puts back what was in the form. @param {import("./types.js").Before} before */
function putBack({ preset, values, tolerances, programmed, terms }) {
  state.tolerances = tolerances
  state.programmed = programmed ?? state.programmed
  if (terms) state.terms = filledTerms(terms)
  actions.setMachine(preset, values)
}

/** @param {number} id @param {Partial<Recording>} what */
function change(id, what) {
  const recording = state.recordings.find((candidate) => candidate.id === id)
  if (recording) Object.assign(recording, what)
}

/** The form with what Rust says about it. @param {number} preset @param {Values} values @returns {MachineForm} */
function filled(preset, values) {
  const json = JSON.stringify(values)
  return { preset, values, faults: JSON.parse(faults(json)), motion: motionOf(json) }
}

/** Which machine to begin with has this name. @param {string | undefined} name */
function presetNamed(name) {
  const index = form.presets.findIndex((preset) => preset.name === name && !preset.removed)
  return index < 0 ? undefined : index
}

/** The same, or else the first. @param {string | undefined} name */
function startNamed(name) {
  return presetNamed(name) ?? 0
}

/** The terms of the quote with what Rust says about them. @param {Values} given @returns {State["terms"]} */
function filledTerms(given) {
  const values = Object.fromEntries(termFields.map(({ key, neutral }) => [key, key in given ? given[key] : neutral]))
  return { values, faults: JSON.parse(termFaults(JSON.stringify(values))) }
}

/** Keeps a machine and chooses it; the function returned takes that back. @param {Values} values */
function adopt(values) {
  const before = now()
  const index = form.presets.push(keptMachine(values)) - 1
  saveMachines(form.presets)
  actions.choosePreset(index)
  return () => {
    form.presets[index].removed = true
    saveMachines(form.presets)
    putBack(before)
  }
}

/** Puts another machine in the place of a kept one; the function returned takes that back. @param {number} index @param {import("./types.js").Preset} preset */
function replaceKept(index, preset) {
  const [before, former] = [now(), form.presets[index]]
  const put = (/** @type {import("./types.js").Preset} */ one) => {
    form.presets[index] = one
    saveMachines(form.presets)
  }
  put(preset)
  if (!preset.removed) actions.choosePreset(index)
  return () => {
    put(former)
    putBack(before)
  }
}

/** Something that results depend on has changed: shows it at once, and computes when it has settled. @param {number} settles  ms */
function changed(settles = DEBOUNCE_MS) {
  state.paused = false
  failure.hidden = true
  history.note(snapshot())
  remember()
  update()
  clearTimeout(timer)
  timer = window.setTimeout(work, settles)
}

/** Keeps the settings for the next visit. */
function remember() {
  saveSettings({
    programmed: state.programmed,
    tolerances: state.tolerances,
    preset: form.presets[state.machine.preset].name,
    values: state.machine.values,
    terms: state.terms.values,
    beside: form.presets[state.beside ?? -1]?.name,
    quoted: state.quoted,
  })
}

/** Puts a calibrated machine in the form, and its tolerance among those shown. @param {import("./types.js").Calibration} calibration */
function take(calibration) {
  const { values, tolerance_mm: tolerance } = calibration.report
  const label = toleranceLabel(tolerance)
  const others = state.tolerances.filter((other) => toleranceLabel(other) !== label)
  state.calibration = calibration
  state.tolerances = [...others.slice(0, mostCurves() - 2), tolerance].sort((a, b) => a - b)
  actions.setMachine(state.machine.preset, values)
}

const progress = progressPanel.mount(element('progress'), actions)
const chart = chartPanel.mount(element('chart'))
const work = workOn(state, engine, {
  update,
  progress: () => progress.update(state),
  fail,
  hasCurve: () => whenIdle(second),
  now,
  take,
})
const exchange = settingsPanel.mount(element('settings'), element('notice'), actions)
const machine = machinePanel.mount(element('machine'), form, actions)
const recordings = recordingPanel.mount(element('recording'), actions)
const tolerances = tolerancesPanel.mount(element('tolerances'), { most: mostCurves(), usual: [...usualTolerances()] }, actions)
/** @type {{update(state: State): void}[]} */
const panels = [
  progress,
  historyPanel.mount(element('history'), history, actions),
  programPanel.mount(element('program'), JSON.parse(dialects()), JSON.parse(arcCenters()), actions),
  machine,
  tolerances,
  resultsPanel.mount(element('results'), form, actions),
  chart,
  recordings,
  exchange,
  diagnosticsPanel.mount(element('diagnostics')),
]

/** The panels that can wait for the first chart. @type {Promise<{path: ReturnType<typeof import("./panels/path.js").mount>}> | undefined} */
let others

/** Mounts what can wait, once, with the whole module; from then on that computes as well. */
function second() {
  others ??= mountOthers().catch((error) => {
    others = undefined
    throw error
  })
  return others
}

async function mountOthers() {
  // What these draw and compute with is there before they are.
  const [compiled] = await Promise.all([wholeModule(), whole()])
  engine.prefer(compiled)
  engine.warm()
  const [breakdown, calibration, compare, cutting, diagnosis, path, quote] = await Promise.all([
    import('./panels/breakdown.js'),
    import('./panels/calibration.js'),
    import('./panels/compare.js'),
    import('./panels/cutting.js'),
    import('./panels/diagnosis.js'),
    import('./panels/path.js'),
    import('./panels/quote.js'),
  ])
  const newEngine = () => new Engine(compiled, confinedWorker, wholeModule)
  const own = { path: path.mount(element('path'), actions) }
  panels.push(
    compare.mount(element('compare'), newEngine(), form, actions),
    own.path,
    calibration.mount(element('calibration'), actions),
    diagnosis.mount(element('diagnosis'), newEngine(), actions),
    breakdown.mount(element('breakdown'), actions),
    quote.mount(element('quote'), form, actions),
    cutting.mount(element('cutting'), newEngine(), actions),
  )
  update()
  import('./stored.js').then((stored) => stored.deleteClosed())
  document.documentElement.dataset.whole = 'true'
  return own
}

/** Does something when the page has drawn and has nothing else to do. @param {() => void} what */
function whenIdle(what) {
  // A picture hears that it is in sight after the frame in which it appears.
  requestAnimationFrame(() => requestAnimationFrame(() => drawn().then(() => setTimeout(what))))
}

function update() {
  saveOpen(state)
  document.body.classList.toggle('has-programs', state.programs.length > 0)
  document.body.classList.toggle('has-recording', recordingOf(state) !== undefined)
  document.body.classList.toggle('moves-nothing', isStill(state.programs.find(({ id }) => id === state.selected)?.outcome))
  for (const panel of panels) panel.update(state)
}

if (state.programs.length + state.recordings.length > 0) changed()
update()
await exchange.fromAddress()
document.documentElement.dataset.ready = 'true'
// Who has read the page so far has a program at hand.
whenIdle(() => engine.warm())
