// The chart of the simulated tolerances: fills it, and says what it shows at a place.

import { Chart, mostCurves } from '../pkg/truefeed.js'
import { addCurve, columnsOf, machineOf, quotedColumn } from '../columns.js'
import { find, make } from '../dom.js'
import { clock, feedNumber, feedrate, lengthLabel, seconds } from '../format.js'
import { deviationLabel } from '../labels.js'
import { namedIn, operationAt, operationTitle, toolTitle } from '../operations.js'
import { mountPlot } from '../plot.js'
import { say } from '../texts.js'

/** @import { Filled } from "../plot.js" */
/** @import { Column, Operation, Outcome, Place, Program, State } from "../types.js" */
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
  /** The one that is quoted, which lies over all others. */
  let quoted = 0
  /** The path that the view fits: its program and its length. @type {string | undefined} */
  let fitted
  const plot = mountPlot(root, chart, {
    isShown: () => Boolean(outcome),
    words: (pointer) => words(pointer, program, operations(), over.value === 'time'),
    operations: () => operations(),
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

  /** What is run in order, by the first tolerance that has been simulated. @returns {Operation[]} */
  const operations = () => namedIn(program, outcome?.runs.get(columns.find((column) => outcome?.runs.has(column)) ?? null)?.summary.operations ?? [])

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
    chart.setOnTop(quoted)
    if (over.value === 'time') chart.setOverTime(true)
  }

  /** Gives the colours of the chart to chips, table and read-out. */
  function colors() {
    chart.setDark(dark.matches)
    for (let index = 0; index <= mostCurves(); index += 1) document.documentElement.style.setProperty(`--curve-${index}`, chart.color(index))
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
      columns = columnsOf(state, program)
      quoted = Math.max(columns.indexOf(quotedColumn(state, program)), 0)
      const runs = columns.filter((column) => outcome?.runs.has(column))
      empty.hidden = Boolean(outcome)
      empty.textContent = state.progress ? say.common.computing : say.common.notComputed
      canvas.hidden = !outcome
      root.classList.toggle('stale', Boolean(outcome) && outcome?.motion !== machineOf(state).motion)
      const now = [state.lengthUnit, program, program?.found, outcome, quoted, ...columns, ...runs]
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

/** What the chart says about one place. @param {Pointer} pointer @param {Program | undefined} program @param {Operation[]} operations @param {boolean} isOverTime */
function words({ distance, line, programmed, rapid, curves }, program, operations, isOverTime) {
  const rows = curves.map(({ label, index, feedrate: feed, range, time, error }) =>
    make(
      'tr',
      {},
      make('th', { scope: 'row' }, make('span', { className: `swatch curve-${index}` }), label),
      make('td', {}, feedrate(feed), rangeOf(range)),
      make('td', {}, error === undefined ? '–' : say.chart.off(deviationLabel(error))),
      make('td', {}, time < 60 ? seconds(time) : clock(time)),
    ),
  )
  const first = isOverTime && curves.length > 1 ? [make('p', { className: 'small' }, say.chart.placeOf(curves[0].label))] : []
  const here = operations.length > 1 ? operationAt(operations, distance) : undefined
  const tool = here ? [make('p', { className: 'small' }, `${toolTitle(here)} · ${operationTitle(here)}`)] : []
  return [headOf(distance, programmed, rapid), ...tool, ...first, make('table', {}, ...rows), ...lineOf(line, program)]
}

/** The least and the largest where a mean is shown. @param {Float64Array} range  mm/min */
export const rangeOf = (range) => (range.length > 0 ? make('span', { className: 'range' }, say.charts.mean(feedNumber(range[0]), feedNumber(range[1]))) : '')

/** Where it is and what is programmed there. @param {number} distance @param {number | undefined} programmed @param {boolean} rapid */
export function headOf(distance, programmed, rapid) {
  const asked = programmed === undefined ? '' : ` · ${rapid ? say.chart.rapid(feedrate(programmed)) : say.chart.programmed(feedrate(programmed))}`
  return make('p', {}, make('strong', {}, lengthLabel(distance)), asked)
}

/** The line of the program, with its number. @param {number | undefined} line @param {Program | undefined} program */
export function lineOf(line, program) {
  if (line === undefined) return []
  const code = make('code', {})
  program?.lines.at(line).then((text) => (code.textContent = text))
  return [make('p', { className: 'code' }, say.chart.line(line), code)]
}
