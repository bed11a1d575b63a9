// Cutting forces, on request: a cutting job as text, peaks by the programmed and by the predicted feedrate, remarks and
// the loads over the distance.

import { LoadPicture, exampleCutting } from '../pkg/truefeed.js'
import { columnLabel, columnsOf } from '../columns.js'
import { find, make } from '../dom.js'
import { Ended } from '../engine.js'
import { number } from '../format.js'

/** @import { Engine } from "../engine.js" */
/** @import { Column, CutPeaks, CutResult, Program, State } from "../types.js" */

/** @type {[keyof CutPeaks, string, string][]} */
const PEAKS = [
  ['force_n', 'Force', 'N'],
  ['torque_nm', 'Torque', 'N·m'],
  ['power_w', 'Power', 'W'],
  ['removal_rate_mm3_min', 'Removal rate', 'mm³/min'],
]

/** @param {HTMLElement} root @param {Engine} engine  of its own, so that it does not end a simulation */
export function mount(root, engine) {
  const job = /** @type {HTMLTextAreaElement} */ (find(root, 'textarea'))
  const compute = /** @type {HTMLButtonElement} */ (find(root, '.compute'))
  const chosen = /** @type {HTMLSelectElement} */ (find(root, 'select'))
  const fault = find(root, '.fault')
  const result = find(root, '.result')
  const plot = find(root, '.loads')
  const canvas = /** @type {HTMLCanvasElement} */ (find(root, 'canvas'))
  const dark = window.matchMedia('(prefers-color-scheme: dark)')
  /** @type {Program | undefined} */
  let program
  /** @type {string} */
  let machine = ''
  /** @type {Column[]} */
  let columns = []
  /** What the result in sight belongs to. @type {string | undefined} */
  let shown
  /** @type {LoadPicture | null} */
  let picture = null

  job.value = exampleCutting()
  job.addEventListener('input', clear)
  chosen.addEventListener('change', clear)
  compute.addEventListener('click', run)
  dark.addEventListener('change', draw)
  new ResizeObserver(draw).observe(plot)

  function clear() {
    engine.cancel()
    shown = undefined
    fault.textContent = ''
    result.replaceChildren()
    plot.hidden = true
    picture?.free()
    picture = null
  }

  async function run() {
    if (!program) return
    clear()
    compute.disabled = true
    result.replaceChildren(make('p', {}, 'Computing …'))
    const { file, dialect } = program
    const tolerance = columns[chosen.selectedIndex] ?? null
    const of = subject()
    try {
      const cut = await engine.cut({ program: file, machine, dialect, tolerance, job: job.value })
      if (of !== subject()) return clear()
      show(cut)
      shown = of
    } catch (error) {
      if (!(error instanceof Ended && error.kind === 'cancelled')) {
        result.replaceChildren()
        fault.textContent = error instanceof Error ? error.message : String(error)
      }
    } finally {
      compute.disabled = false
    }
  }

  /** What a result would be of now. */
  function subject() {
    return JSON.stringify([program?.id, program?.dialect, machine, columns[chosen.selectedIndex]])
  }

  /** @param {CutResult} cut */
  function show({ summary, columns: loads }) {
    const { cutting, operations } = summary.runs[0]
    const remarks = summary.diagnostics.map(({ line, severity, message }) =>
      make('li', { className: severity }, line ? `Line ${line}: ${message}` : message),
    )
    result.replaceChildren(...(remarks.length ? [make('ul', {}, ...remarks)] : []))
    if (!cutting) return
    const peaks = PEAKS.map(([key, title, unit]) => {
      const { programmed, predicted } = cutting
      const cells = [programmed[key], predicted[key]].map(({ value, line }) => [number(value), String(line)])
      return row(`${title} (${unit})`, cells.flat())
    })
    const parts = operations.flatMap(({ line, name, cutting: own }) =>
      own ? [row(`${line} ${name ?? ''}`, [own.removed_mm3, own.peak_force_n.value, own.peak_power_w.value].map(number))] : [],
    )
    result.append(
      table(['Largest', 'Programmed feed', 'Line', 'Predicted feed', 'Line'], peaks),
      table(['Operation', 'Removed (mm³)', 'Force (N)', 'Power (W)'], parts),
      make('p', { className: 'help' }, `Stock in cells of ${number(cutting.resolution_mm)} mm; ${cutting.assumptions}.`),
    )
    const { distance, programmedForce, predictedForce, programmedPower, predictedPower, programmedRate, predictedRate } = loads
    picture = new LoadPicture(
      distance,
      programmedForce,
      predictedForce,
      programmedPower,
      predictedPower,
      programmedRate,
      predictedRate,
    )
    plot.hidden = false
    draw()
  }

  function draw() {
    const { clientWidth: width, clientHeight: height } = plot
    if (picture && width && height) picture.draw(canvas, width, height, window.devicePixelRatio, dark.matches)
  }

  return {
    /** @param {State} state */
    update(state) {
      program = state.programs.find(({ id }) => id === state.selected)
      machine = JSON.stringify(state.machine.values)
      root.hidden = !program
      compute.disabled = !program || state.machine.motion === undefined
      const now = columnsOf(state, program?.outcome)
      if (now.length !== columns.length || now.some((column, index) => column !== columns[index])) {
        const before = chosen.value
        columns = [...now]
        chosen.replaceChildren(...columns.map((column) => make('option', {}, columnLabel(column))))
        if (columns.some((column) => columnLabel(column) === before)) chosen.value = before
      }
      if (shown !== undefined && shown !== subject()) clear()
    },
  }
}

/** @param {string} title @param {string[]} cells */
function row(title, cells) {
  return make('tr', {}, make('th', { scope: 'row' }, title), ...cells.map((cell) => make('td', {}, cell)))
}

/** @param {string[]} titles @param {HTMLElement[]} rows */
function table(titles, rows) {
  const head = titles.map((title) => make('th', { scope: 'col' }, title))
  const body = make('table', {}, make('thead', {}, make('tr', {}, ...head)), make('tbody', {}, ...rows))
  return make('div', { className: 'scroll' }, body)
}
