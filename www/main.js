// Starts the page: owns the one state object, queues simulations and tells the panels what changed.

import init, {
  faults,
  form as formOfModule,
  mostCurves,
  motionOf,
  usualTolerances,
} from './pkg/truefeed.js'
import { columnLabel, columnsOf } from './columns.js'
import { Ended, Engine } from './engine.js'
import * as breakdownPanel from './panels/breakdown.js'
import * as chartPanel from './panels/chart.js'
import * as diagnosticsPanel from './panels/diagnostics.js'
import * as machinePanel from './panels/machine.js'
import * as programPanel from './panels/program.js'
import * as progressPanel from './panels/progress.js'
import * as resultsPanel from './panels/results.js'
import * as tolerancesPanel from './panels/tolerances.js'
import { loadSettings, saveSettings } from './settings.js'

/** @import { Column, Form, MachineForm, Outcome, Place, Program, State, Value, Values } from "./types.js" */

const DEBOUNCE_MS = 300

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id))
const failure = element('failure')

/** Says what should never happen, rather than leaving a page that does nothing. @param {string} message */
function fail(message) {
  failure.textContent = `${message} This is a fault of Truefeed, not of your program.`
  failure.hidden = false
}
window.addEventListener('error', ({ message }) => fail(`Something went wrong: ${message}.`))
window.addEventListener('unhandledrejection', ({ reason }) => fail(`Something went wrong: ${reason}.`))

const module = await WebAssembly.compile(
  await (await fetch(new URL('pkg/truefeed_bg.wasm', import.meta.url))).arrayBuffer(),
)
await init({ module_or_path: module })
const engine = new Engine(module)

/** @type {Form} */
const form = JSON.parse(formOfModule())
const settings = loadSettings()

const knownPreset = Math.max(
  form.presets.findIndex(({ name }) => name === settings.preset),
  0,
)

/** @type {State} */
const state = {
  programs: [],
  selected: null,
  programmed: settings.programmed ?? true,
  tolerances: settings.tolerances ?? [...usualTolerances()],
  machine: filled(knownPreset, { ...(settings.values ?? form.presets[knownPreset].values) }),
  progress: null,
  paused: false,
}

let nextId = 1
let timer = 0

/** What panels may ask for. */
export const actions = {
  /** @param {{name: string, bytes: Uint8Array}[]} files */
  addPrograms(files) {
    for (const { name, bytes } of files) {
      state.programs.push({ id: nextId++, name, bytes, lines: linesOf(bytes), outcome: null, failure: null })
    }
    state.selected = state.programs[state.programs.length - files.length]?.id ?? state.selected
    changed()
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
    actions.setMachine(state.machine.preset, { ...state.machine.values, [key]: value })
  },
  /** @param {Pick<Place, 'distance_mm'>} place */
  show(place) {
    chart.show(place)
  },
  /** @param {number[]} tolerances  mm */
  setTolerances(tolerances) {
    state.tolerances = [...tolerances].sort((a, b) => a - b)
    changed()
  },
  /** Shows the program's own tolerances, or not. @param {boolean} shown */
  setProgrammed(shown) {
    state.programmed = shown
    changed()
  },
  cancel() {
    state.paused = true
    engine.cancel()
    update()
  },
  resume() {
    state.paused = false
    changed()
  },
}

/** The lines of a program, told apart when they are first asked for. @param {Uint8Array} bytes */
function linesOf(bytes) {
  /** @type {string[] | undefined} */
  let lines
  return () => (lines ??= new TextDecoder().decode(bytes).split(/\r\n|\n|\r/))
}

/** The form with what Rust says about it. @param {number} preset @param {Values} values @returns {MachineForm} */
function filled(preset, values) {
  const json = JSON.stringify(values)
  return { preset, values, faults: JSON.parse(faults(json)), motion: motionOf(json) }
}

/** Something that results depend on has changed: shows it at once, and computes when it has settled. */
function changed() {
  state.paused = false
  failure.hidden = true
  saveSettings({
    programmed: state.programmed,
    tolerances: state.tolerances,
    preset: form.presets[state.machine.preset].name,
    values: state.machine.values,
  })
  update()
  clearTimeout(timer)
  timer = window.setTimeout(work, DEBOUNCE_MS)
}

/** The columns a program still lacks on the machine as it is now. @param {Program} program @returns {Column[]} */
export function missing(program) {
  const current = program.outcome?.motion === state.machine.motion ? program.outcome : null
  if (current) return columnsOf(state, current).filter((column) => !current.runs.has(column))
  // Whether it sets a tolerance is known when it is read.
  return state.programmed ? [null, ...state.tolerances] : state.tolerances
}

/** Simulates what is missing, the selected program first, until nothing is. */
async function work() {
  if (state.progress) return
  for (;;) {
    const selectedFirst = [...state.programs].sort(
      (a, b) => Number(b.id === state.selected) - Number(a.id === state.selected),
    )
    const program = selectedFirst.find(
      (candidate) => missing(candidate).length > 0 && candidate.failure !== state.machine.motion,
    )
    const { motion } = state.machine
    if (!program || state.paused || motion === undefined) break
    if (!(await simulate(program, motion))) break
  }
  state.progress = null
  update()
}

/** Simulates what one program lacks; false where that was cancelled. @param {Program} program @param {string} motion */
async function simulate(program, motion) {
  const machine = JSON.stringify(state.machine.values)
  const columns = missing(program)
  const isForOther = program.outcome !== null && program.outcome.motion !== motion
  /** @type {Outcome | null} */
  let outcome = null
  state.progress = { program: program.id, stage: 'Starting', part: 0 }
  const listener = {
    stage(/** @type {string} */ text, /** @type {number} */ part) {
      state.progress = { program: program.id, stage: text, part }
      progress.update(state)
    },
    program(/** @type {any} */ summary, /** @type {any} */ steps, /** @type {any} */ held) {
      outcome = { motion, summary, steps, held, runs: new Map(isForOther ? [] : program.outcome?.runs) }
      // What was computed for another machine stays in sight until all is there.
      if (!isForOther) program.outcome = outcome
    },
    run(/** @type {Column} */ column, /** @type {any} */ run) {
      outcome?.runs.set(column, run)
      update()
    },
  }
  try {
    update()
    const labels = columns.map(columnLabel)
    await engine.simulate({ program: program.bytes, machine, columns, labels }, listener)
    program.outcome = outcome
    program.failure = null
  } catch (error) {
    if (error instanceof Ended && error.kind === 'cancelled') return false
    program.failure = motion
    fail(`${program.name} could not be simulated: ${error instanceof Error ? error.message : error}.`)
  }
  return true
}

const progress = progressPanel.mount(element('progress'), actions)
const chart = chartPanel.mount(element('chart'))
const panels = [
  progress,
  programPanel.mount(element('program'), actions),
  machinePanel.mount(element('machine'), form, actions),
  tolerancesPanel.mount(element('tolerances'), { most: mostCurves(), usual: [...usualTolerances()] }, actions),
  resultsPanel.mount(element('results'), form, actions),
  chart,
  breakdownPanel.mount(element('breakdown'), actions),
  diagnosticsPanel.mount(element('diagnostics')),
]

function update() {
  document.body.classList.toggle('has-programs', state.programs.length > 0)
  for (const panel of panels) panel.update(state)
}

update()
document.documentElement.dataset.ready = 'true'
