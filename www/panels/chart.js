// The chart of the simulated tolerances: fills it, and says what it shows at a place.

import { Chart, mostCurves } from '../pkg/truefeed.js'
import { addCurve, columnsOf } from '../columns.js'
import { find, make } from '../dom.js'
import { feedrate, millimetres, clock, seconds } from '../format.js'
import { deviationLabel } from '../labels.js'
import { mountPlot } from '../plot.js'
import { say } from '../texts.js'

/** @import { Filled } from "../plot.js" */
/** @import { Column, Outcome, Place, Program, State } from "../types.js" */
/** @import { Pointer } from "../pkg/truefeed.js" */

/** @param {HTMLElement} root */
export function mount(root) {
  const chart = new Chart()
  const canvas = find(root, 'canvas')
  const empty = find(root, '.empty')
  const note = find(root, '.note')
  const dark = window.matchMedia('(prefers-color-scheme: dark)')

  /** @type {Program | undefined} */
  let program
  /** What is in the chart now, so that it is filled anew only when something else is to be shown. @type {unknown[]} */
  let filled = []
  /** @type {Outcome | null | undefined} */
  let outcome
  /** @type {Column[]} */
  let columns = []
  /** The path that the view fits: its program and its length. @type {string | undefined} */
  let fitted
  const plot = mountPlot(root, chart, {
    isShown: () => Boolean(outcome),
    words: (pointer) => words(pointer, program, over.value === 'time'),
    fill(twin) {
      if (outcome) fill(twin, outcome)
      twin.setStacked(stack.checked)
    },
  })
  dark.addEventListener('change', colors)
  const over = /** @type {HTMLSelectElement} */ (find(root, '.over'))
  const stack = /** @type {HTMLInputElement} */ (find(root, '.stack'))
  over.addEventListener('change', () => {
    chart.setOverTime(over.value === 'time')
    plot.hide()
    plot.redraw()
  })
  stack.addEventListener('change', () => {
    chart.setStacked(stack.checked)
    root.classList.toggle('stacked', stack.checked)
    plot.redraw()
  })

  /** Puts program and curves into a chart. @param {Filled} chart @param {Outcome} outcome */
  function fill(chart, { steps: { end, feedrate, rapid, line }, held, runs }) {
    chart.program(end, feedrate, rapid, line)
    for (const column of columns) {
      addCurve(chart, column, held)
      const curve = runs.get(column)?.columns
      if (!curve) continue
      chart.fill(curve.distance, curve.feedrate, curve.time)
      chart.fillErrors(curve.corner, curve.arcs, curve.alongArcs)
    }
    if (over.value === 'time') chart.setOverTime(true)
  }

  /** Gives the colours of the chart to chips, table and read-out. */
  function colors() {
    chart.setDark(dark.matches)
    for (let index = 0; index <= mostCurves(); index += 1)
      document.documentElement.style.setProperty(`--curve-${index}`, chart.color(index))
  }
  colors()

  return {
    /** Shows a place of the program and takes the keys. @param {Pick<Place, 'distance_mm'>} place */
    show(place) {
      plot.show(place)
    },
    /** Shows a stretch (mm) and leaves page and keys where they are. @param {[number, number]} stretch */
    reveal(stretch) {
      plot.reveal(stretch)
    },
    /** @param {State} state */
    update(state) {
      program = state.programs.find(({ id }) => id === state.selected)
      outcome = program?.outcome
      columns = columnsOf(state, outcome)
      const runs = columns.filter((column) => outcome?.runs.has(column))
      empty.hidden = Boolean(outcome)
      empty.textContent = state.progress ? say.common.computing : say.common.notComputed
      canvas.hidden = !outcome
      root.classList.toggle('stale', Boolean(outcome) && outcome?.motion !== state.machine.motion)
      const now = [program, outcome, ...columns, ...runs]
      if (now.length === filled.length && now.every((value, index) => value === filled[index])) return
      filled = now
      plot.hide()
      if (!outcome) return
      fill(chart, outcome)
      note.textContent = runs.map((column) => outcome?.runs.get(column)?.note).find(Boolean) ?? ''
      // A path of another length has no use for the view of the former one.
      const path = `${program?.id} ${outcome.steps.end.at(-1)}`
      plot.fit(fitted !== path)
      fitted = path
    },
  }
}

/** What the chart says about one place. @param {Pointer} pointer @param {Program | undefined} program @param {boolean} isOverTime */
function words({ distance, line, programmed, rapid, curves }, program, isOverTime) {
  const rows = curves.map(({ label, feedrate: feed, time, error }, index) =>
    make(
      'tr',
      {},
      make('th', { scope: 'row' }, make('span', { className: `swatch curve-${index}` }), label),
      make('td', {}, feedrate(feed)),
      make('td', {}, error === undefined ? '–' : say.chart.off(deviationLabel(error))),
      make('td', {}, time < 60 ? seconds(time) : clock(time)),
    ),
  )
  const first = isOverTime && curves.length > 1 ? [make('p', { className: 'small' }, say.chart.placeOf(curves[0].label))] : []
  return [headOf(distance, programmed, rapid), ...first, make('table', {}, ...rows), ...lineOf(line, program)]
}

/** Where it is and what is programmed there. @param {number} distance @param {number | undefined} programmed @param {boolean} rapid */
export function headOf(distance, programmed, rapid) {
  const asked = programmed === undefined ? '' : ` · ${rapid ? 'rapid' : 'programmed'} ${feedrate(programmed)}`
  return make('p', {}, make('strong', {}, millimetres(distance)), asked)
}

/** The line of the program, with its number. @param {number | undefined} line @param {Program | undefined} program */
export function lineOf(line, program) {
  if (line === undefined) return []
  const code = make('code', {})
  program?.lines.at(line).then((text) => (code.textContent = text))
  return [make('p', { className: 'code' }, say.chart.line(line), code)]
}
