// Cutting forces, on request: a cutting job as text, peaks by the programmed and by the predicted feedrate, remarks, where
// the feedrate could be higher, and the loads over the distance, with the cursor and the view of the other charts.

import { LoadPicture, materials as materialsText } from '../pkg/truefeed_whole.js'
import { mountTolerance } from '../at_tolerance.js'
import { columnsOf, isStill, machineOf, quotedColumn } from '../columns.js'
import { mountForm } from '../cutting/form.js'
import { fedAlong, formFor } from '../cutting/job.js'
import { find, make, scroll } from '../dom.js'
import { Ended } from '../engine.js'
import { feedrate, figures, number, percent, seconds } from '../format.js'
import { offerPictures } from '../pictures.js'
import { join } from '../plot.js'
import { say } from '../texts_later.js'
import { headOf, lineOf } from './chart.js'

/** @import { Engine } from "../engine.js" */
/** @import { CuttingForm } from "../cutting/job.js" */
/** @import { Cut, CutMaterial, CutPeak, CutPeaks, CutResult, Place, Program, State } from "../types.js" */

/** What is around a peak that is shown, mm. */
const AROUND_MM = 5
/** Rows of where the feedrate could be higher. */
const ROOMS = 12
/** @type {Record<string, string>} */
const LIMITS = {
  tool_force: say.cutting.toolForce,
  tool_torque: say.cutting.toolTorque,
  tool_power: say.cutting.toolPower,
  tool_chip: say.cutting.chip,
  tool_deflection: say.cutting.toolBend,
  spindle_force: say.cutting.spindleForce,
  spindle_torque: say.cutting.spindleTorque,
  spindle_power: say.cutting.spindlePower,
}

/** @type {[keyof CutPeaks, string, string][]} */
const PEAKS = [
  ['force_n', say.cutting.force, 'N'],
  ['torque_nm', say.cutting.torque, 'N·m'],
  ['power_w', say.cutting.power, 'W'],
  ['removal_rate_mm3_min', say.cutting.removalRate, 'mm³/min'],
]

/**
 * @param {HTMLElement} root
 * @param {Engine} engine  of its own, so that it does not end a simulation
 * @param {{show(place: Pick<Place, "distance_mm">): void, setCut(cut: Cut | null): void}} actions
 */
export function mount(root, engine, actions) {
  /** @type {(CutMaterial & {word: string})[]} */
  const materials = JSON.parse(materialsText())
  const form = mountForm(find(root, '.form'), materials, forget)
  const compute = /** @type {HTMLButtonElement} */ (find(root, '.compute'))
  const fault = find(root, '.fault')
  const result = find(root, '.result')
  const plot = find(root, '.loads')
  const canvas = /** @type {HTMLCanvasElement} */ (find(root, 'canvas'))
  const cross = find(plot, '.cross')
  const reading = find(plot, '.reading')
  const working = find(root, '.working')
  const bar = /** @type {HTMLProgressElement} */ (find(working, 'progress'))
  const dark = window.matchMedia('(prefers-color-scheme: dark)')
  /** @type {Program | undefined} */
  let program
  /** @type {string} */
  let machine = ''
  /** @type {{motion: string | undefined}} */
  let current = { motion: undefined }
  /** The forms of programs, as they were filled in. @type {WeakMap<Program, CuttingForm>} */
  const forms = new WeakMap()
  /** Whose form is in sight. @type {Program | undefined} */
  let filled
  /** What the result in sight belongs to. @type {string | undefined} */
  let shown
  /** That result. @type {CutResult | null} */
  let computed = null
  let unit = ''
  /** @type {LoadPicture | null} */
  let picture = null
  /** How the teeth are fed. @type {ReturnType<typeof fedAlong> | undefined} */
  let fed
  /** Distances in sight, mm. @type {[number, number]} */
  let span = [0, 1]
  /** The path on the canvas, pixels. @type {[number, number]} */
  let sides = [0, 1]

  offerPictures(find(root, '.tools'), 'cutting', say.cutting.picture, () => picture?.svg(plot.clientWidth, plot.clientHeight))
  find(root, '.materials').append(materialsTable(materials))
  const at = mountTolerance(/** @type {HTMLSelectElement} */ (find(root, 'select.tolerance')), forget)
  compute.addEventListener('click', run)
  find(working, '.cancel').addEventListener('click', forget)
  dark.addEventListener('change', draw)
  new ResizeObserver(draw).observe(plot)

  const others = join({
    isShown: () => picture !== null && !plot.hidden,
    redraw: draw,
    hide,
    show: () => {},
    reveal: () => {},
    fit: () => {},
    follow(from, to) {
      span = [from, to]
      draw()
    },
    point: (distance) => read(distance, true),
    span: () => span,
  })
  plot.addEventListener('pointermove', (event) => {
    const distance = distanceAt(event)
    if (distance === undefined) return (others.leave(), hide())
    read(distance, false)
    others.point(distance)
  })
  plot.addEventListener('pointerleave', () => {
    hide()
    others.leave()
  })
  plot.addEventListener('click', (event) => {
    const distance = distanceAt(event)
    if (distance !== undefined) actions.show(around(distance))
  })

  /** @param {MouseEvent} event */
  function distanceAt(event) {
    const x = event.clientX - plot.getBoundingClientRect().left
    if (x < sides[0] || sides[1] < x) return undefined
    return span[0] + ((x - sides[0]) / (sides[1] - sides[0])) * (span[1] - span[0])
  }

  function hide() {
    cross.hidden = true
    reading.hidden = true
  }

  /** Shows the cursor, and what the loads are there. @param {number} distance @param {boolean} passive  another chart has the pointer */
  function read(distance, passive) {
    if (!picture || distance < span[0] || span[1] < distance) return hide()
    const x = sides[0] + ((distance - span[0]) / (span[1] - span[0])) * (sides[1] - sides[0])
    cross.hidden = false
    Object.assign(cross.style, { left: `${x}px`, top: '0', height: `${plot.clientHeight}px` })
    reading.hidden = passive
    if (passive) return
    const loads = picture.reading(distance)
    const rows = [
      [say.cutting.force, 'N'],
      [say.cutting.power, 'W'],
      [say.cutting.removal, 'cm³/min'],
    ].map(([title, unit], index) =>
      row(
        title,
        [0, 1].map((which) => `${figures(loads[2 * index + which])} ${unit}`),
      ),
    )
    const body = make('table', {}, row('', [say.charts.programmed, say.charts.predicted]), ...rows)
    const line = lineAt(distance)
    reading.replaceChildren(headOf(distance, undefined, false), body, ...lineOf(line, program))
    const toTheLeft = x > (sides[0] + sides[1]) / 2
    reading.style.left = toTheLeft ? 'auto' : `${x + 12}px`
    reading.style.right = toTheLeft ? `${plot.clientWidth - x + 12}px` : 'auto'
    reading.style.top = '8px'
  }

  /** The line that is run at a distance. @param {number} distance */
  function lineAt(distance) {
    const steps = program?.outcome?.steps
    if (!steps) return undefined
    let [low, high] = [0, steps.end.length - 1]
    while (low < high) {
      const middle = (low + high) >> 1
      if (steps.end[middle] < distance) low = middle + 1
      else high = middle
    }
    return steps.line[low]
  }

  /** Where a line is run first; nowhere where it does not move. @param {number} line @returns {[number, number] | undefined} */
  function placeOf(line) {
    const steps = program?.outcome?.steps
    const index = steps?.line.indexOf(line) ?? -1
    return steps && index >= 0 ? [steps.end[index - 1] ?? 0, steps.end[index]] : undefined
  }

  /** A line of the program, and the way to it in the chart. @param {number} line @param {[number, number] | undefined} place @param {string} [text] */
  function way(line, place, text = String(line)) {
    if (!place) return text
    const go = make('button', { type: 'button' }, text)
    program?.lines.at(line).then((code) => (go.title = say.cutting.showCode(code)))
    go.setAttribute('aria-label', say.cutting.showLine(text))
    go.addEventListener('click', () => actions.show({ distance_mm: place }))
    return go
  }

  /** Forgets what was computed, or ends what is being computed. */
  function forget() {
    clear()
    actions.setCut(null)
  }

  function clear() {
    engine.cancel()
    shown = undefined
    computed = null
    fault.textContent = ''
    result.replaceChildren()
    plot.hidden = true
    find(root, '.tools').hidden = true
    picture?.free()
    picture = null
    fed = undefined
  }

  /** Feed per tooth by tool, with the way to where it is wrong first. @param {ReturnType<typeof fedAlong>["byTool"]} byTool */
  function perToothTable(byTool) {
    const rows = [...byTool].map(([{ number: tool, name }, { largest, cut, rubbing, overload, first }]) => {
      const share = (/** @type {number} */ length, /** @type {number | undefined} */ from, /** @type {string} */ title) => {
        if (from === undefined) return say.cutting.never
        const go = make('button', { type: 'button', title }, percent(length / cut).replace('+', ''))
        go.addEventListener('click', () => actions.show(around(from)))
        return go
      }
      const called = [tool === null ? '' : `T${tool}`, name].filter(Boolean).join(' ')
      return row(called || say.charts.noTool, [number(largest), share(rubbing, first.rubbing, say.cutting.showRubbing), share(overload, first.overload, say.cutting.showOverload)])
    })
    return table([say.breakdown.tool, say.cutting.largestPerTooth, say.cutting.rubs, say.cutting.overloads], rows, say.cutting.perTooth)
  }

  async function run() {
    if (!program) return
    clear()
    const lacking = form.tools().filter(({ diameter, teeth }) => diameter === null || teeth === null)
    if (lacking.length > 0 && !hasTable()) {
      fault.textContent = say.cutting.incomplete(lacking.map(({ number, name }) => (number === null ? name || say.charts.noTool : `T${number}`)).join(', '))
      return
    }
    compute.disabled = true
    bar.value = 0
    working.hidden = false
    const stage = (/** @type {string} */ _, /** @type {number} */ part) => (bar.value = part)
    const { id, file, dialect } = program
    const { motion } = current
    const tolerance = at.column() ?? null
    const of = subject()
    try {
      const cut = await engine.cut({ program: file, machine, dialect, tolerance, job: form.text() }, stage)
      if (of !== subject()) return clear()
      show(cut)
      shown = of
      computed = cut
      const operations = cut.summary.runs[0].operations.map(({ cutting }) => cutting)
      const { cutting } = cut.summary.runs[0]
      actions.setCut(cutting ? { program: id, dialect, motion, column: tolerance, operations, rooms: cutting.headroom, fed: fed?.stretches ?? [] } : null)
    } catch (error) {
      if (!(error instanceof Ended && error.kind === 'cancelled')) {
        result.replaceChildren()
        fault.textContent = error instanceof Error ? error.message : String(error)
      }
    } finally {
      compute.disabled = false
      working.hidden = true
    }
  }

  /** What a result would be of now. */
  function subject() {
    return JSON.stringify([program?.id, program?.dialect, machine, at.column()])
  }

  /** Fills the form for the program in sight, once that is computed. @param {State} state */
  function showForm(state) {
    const run = program?.outcome?.runs.get(quotedColumn(state, program))
    if (!program?.outcome || program === filled || !run || isStill(program.outcome)) return
    // What its comments say comes a moment after its times.
    if (!program.described) return
    filled = program
    const entries = forms.get(program) ?? formFor(program.outcome, run.summary.operations, program.described, materials[0].word)
    forms.set(program, entries)
    if (!form.isText()) form.show(entries)
  }

  /** Whether the machine has a table of tools, from which diameters come that the form does not say. */
  const hasTable = () => Object.keys(JSON.parse(machine || '{}')).some((key) => key.startsWith('tools.'))

  /** @param {CutResult} cut */
  function show({ summary, columns: loads }) {
    const { cutting, operations } = summary.runs[0]
    const remarks = summary.diagnostics.map(({ line, severity, message }) => make('li', { className: severity }, ...(line ? [say.cutting.line, way(line, placeOf(line)), `: ${message}`] : [message])))
    result.replaceChildren(...(remarks.length ? [make('ul', {}, ...remarks)] : []))
    if (!cutting) return
    const peaks = PEAKS.map(([key, title, unit]) => {
      const { programmed, predicted } = cutting
      const cells = [programmed[key], predicted[key]].map(({ value, line, distance_mm: at }) => [figures(value), value > 0 ? way(line, around(at).distance_mm) : '–'])
      return row(`${title} (${unit})`, cells.flat())
    })
    const peak = (/** @type {CutPeak} */ { value, line, distance_mm: at }) => [figures(value), value > 0 ? way(line, around(at).distance_mm) : '–']
    const parts = operations.flatMap(({ line, name, cutting: own }) => (own ? [row(`${line} ${name ?? ''}`, [number(own.removed_mm3), ...peak(own.peak_force_n), ...peak(own.peak_power_w)])] : []))
    const rooms = cutting.headroom
      .slice(0, ROOMS)
      .map(({ lines: [from, to], distance_mm: place, ...room }) =>
        row(way(from, place, from === to ? `${from}` : `${from}–${to}`), [
          feedrate(room.programmed_mm_min),
          `× ${room.factor}`,
          room.limit === null ? say.cutting.noLimit : LIMITS[room.limit],
          feedrate(room.predicted_mm_min),
          seconds(room.saved_s),
        ]),
      )
    result.append(
      table([say.cutting.largest, say.cutting.programmedFeed, say.common.line, say.cutting.predictedFeed, say.common.line], peaks),
      table([say.common.operation, say.common.removedMm, say.common.peakForceN, say.common.line, say.common.peakPowerW, say.common.line], parts),
      ...(rooms.length > 0
        ? [
            table([say.common.lines, say.common.programmed, say.cutting.couldBe, say.cutting.thenMeets, say.cutting.predicted, say.cutting.savesMost], rooms, say.cutting.rooms),
            make('p', { className: 'help' }, say.cutting.roomsHelp),
          ]
        : []),
      make('p', { className: 'help' }, say.cutting.legend(figures(cutting.resolution_mm), cutting.assumptions, cutting.material.name, cutting.material.source)),
    )
    fed = fedAlong(loads.distance, loads.predictedPerTooth, form.tools(), operations)
    if (fed.byTool.size > 0) result.append(perToothTable(fed.byTool))
    const { distance, programmedForce, predictedForce, programmedPower, predictedPower, programmedRate, predictedRate } = loads
    picture?.free()
    picture = new LoadPicture(distance, programmedForce, predictedForce, programmedPower, predictedPower, programmedRate, predictedRate)
    plot.hidden = false
    find(root, '.tools').hidden = false
    span = others.span() ?? [distance[0] ?? 0, distance.at(-1) ?? 1]
    draw()
  }

  function draw() {
    const { clientWidth: width, clientHeight: height } = plot
    if (!picture || !width || !height) return
    const [left, right] = picture.draw(canvas, width, height, window.devicePixelRatio, dark.matches, ...span)
    sides = [left, right]
  }

  return {
    /** @param {State} state */
    update(state) {
      program = state.programs.find(({ id }) => id === state.selected)
      const { motion, values } = machineOf(state)
      machine = JSON.stringify(values)
      current = { motion }
      root.hidden = !program
      compute.disabled = !program || motion === undefined
      at.update(columnsOf(state, program), quotedColumn(state, program))
      showForm(state)
      if (shown !== undefined && shown !== subject()) clear()
      if (computed && unit !== state.lengthUnit) show(computed)
      unit = state.lengthUnit
    },
  }
}

/** What is around a peak. @param {number} distance @returns {Pick<Place, "distance_mm">} */
const around = (distance) => ({ distance_mm: [Math.max(distance - AROUND_MM, 0), distance + AROUND_MM] })

/** @param {Node | string} title @param {(Node | string)[]} cells */
function row(title, cells) {
  return make('tr', {}, make('th', { scope: 'row' }, title), ...cells.map((cell) => make('td', {}, cell)))
}

/** @param {(CutMaterial & {word: string})[]} materials */
function materialsTable(materials) {
  const rows = materials.map(({ word, name, source, is_checked: isChecked, cutting_n_mm2: cutting, edge_n_mm: edge }) => {
    const from = make('td', { className: isChecked ? 'source' : 'source unchecked' }, source)
    const cells = row(word, [name, ...[...cutting, ...edge].map((value) => figures(value))])
    cells.append(from)
    return cells
  })
  const titles = [say.cutting.word, say.cutting.material, 'K_tc', 'K_rc', 'K_ac', 'K_te', 'K_re', 'K_ae', say.cutting.source]
  return table(titles, rows, say.cutting.coefficients)
}

/** @param {string[]} titles @param {HTMLElement[]} rows @param {string} [caption] */
function table(titles, rows, caption) {
  const head = titles.map((title) => (title ? make('th', { scope: 'col' }, title) : make('td', {})))
  const title = caption ? [make('caption', {}, caption)] : []
  const body = make('table', {}, ...title, make('thead', {}, make('tr', {}, ...head)), make('tbody', {}, ...rows))
  return scroll(body)
}
