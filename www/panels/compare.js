// Side by side: the tolerances as columns, on this machine and on another one, and below them the cycle time over
// the tolerance. A click on the line adds a tolerance.

import { TolerancePicture, curveTolerances, price } from '../pkg/truefeed_whole.js'
import { columnLabel, columnsOf } from '../columns.js'
import { find, make, offer } from '../dom.js'
import { sheetOf, whenStill } from '../drawing.js'
import { clock, difference, money, percent, seconds } from '../format.js'
import { deviationLabel, toleranceLabel } from '../labels.js'
import { offerPictures } from '../pictures.js'
import { say } from '../texts_later.js'
import { Times, asked, coarseFirst } from '../times.js'

/** @import { Engine } from "../engine.js" */
/** @import { Column, Form, Outcome, Program, State, Values } from "../types.js" */
/** @import { Asked } from "../times.js" */

const KEY_PX = 6

/** One machine with its cycle times. @typedef {{name: string, values: Values, machine: Asked, times: Map<Column, number>}} Side */

/**
 * @param {HTMLElement} root
 * @param {Engine} engine
 * @param {Form} form
 * @param {{setBeside(preset: number | null): void, addTolerance(tolerance: number): void}} actions
 */
export function mount(root, engine, form, actions) {
  const beside = /** @type {HTMLSelectElement} */ (find(root, '.beside'))
  const table = find(root, '.columns')
  const plot = find(root, '.curve')
  const canvas = /** @type {HTMLCanvasElement} */ (find(plot, 'canvas'))
  const [cross, reading] = [find(plot, '.cross'), find(plot, '.reading')]
  const legend = find(root, '.legend')
  const points = find(root, '.points')
  const stop = find(root, '.stop')
  const standing = find(root, '.standing')
  const dark = window.matchMedia('(prefers-color-scheme: dark)')
  const all = [...curveTolerances()]
  const times = new Times(engine)
  /** @type {TolerancePicture | null} */
  let picture = null
  /** @type {Side[]} */
  let sides = []
  /** @type {State | null} */
  let state = null
  let stopped = ''
  let at = NaN

  const sheet = sheetOf(canvas, () => picture?.draw(canvas, sheet.width, sheet.height, sheet.ratio(), dark.matches))
  const draw = sheet.redraw

  offerPictures(find(root, '.tools'), 'tolerances', say.compare.curvePicture, () => picture?.svg(sheet.width, sheet.height))
  beside.addEventListener('change', () => actions.setBeside(beside.value === '' ? null : Number(beside.value)))
  stop.addEventListener('click', () => {
    const running = stopped === ''
    stopped = running ? subject() : ''
    if (running) times.stop()
    again()
  })
  dark.addEventListener('change', draw)
  plot.addEventListener('pointermove', (event) => read(column(event)))
  plot.addEventListener('pointerleave', hide)
  plot.addEventListener('blur', hide)
  plot.addEventListener('click', (event) => {
    const tolerance = picture?.toleranceAt(column(event))
    if (tolerance !== undefined) actions.addTolerance(tolerance)
  })
  plot.addEventListener('keydown', (event) => {
    const step = { ArrowLeft: -KEY_PX, ArrowRight: KEY_PX }[event.key]
    if (event.key === 'Escape') return hide()
    if (event.key === 'Enter' && Number.isFinite(at)) return actions.addTolerance(at)
    if (!step || !picture) return
    event.preventDefault()
    const [x] = picture.columnOf(Number.isFinite(at) ? at : all[all.length >> 1])
    const before = at
    // Where one step does not change what would be typed, several do.
    for (let to = x + step; 0 < to && to < sheet.width; to += step) {
      read(to)
      if (at !== before) break
    }
  })

  /** @param {MouseEvent} event */
  const column = (event) => event.clientX - plot.getBoundingClientRect().left - plot.clientLeft

  function hide() {
    at = NaN
    cross.hidden = true
    reading.hidden = true
  }

  /** Reads at a pixel column. @param {number} x */
  function read(x) {
    const tolerance = picture?.toleranceAt(x)
    if (!picture || tolerance === undefined) return hide()
    at = tolerance
    const [left, top, bottom] = picture.columnOf(tolerance)
    cross.hidden = false
    Object.assign(cross.style, { left: `${left}px`, top: `${top}px`, height: `${bottom - top}px` })
    const found = [...picture.times(tolerance)]
    const rows = sides
      .slice(0, found.length)
      .map(({ name }, index) => make('p', {}, sides.length > 1 ? `${name}: ` : '', make('strong', {}, Number.isFinite(found[index]) ? say.compare.about(seconds(found[index])) : '…')))
    reading.hidden = false
    reading.replaceChildren(make('p', {}, make('strong', {}, toleranceLabel(tolerance))), ...rows, make('p', { className: 'small' }, say.compare.clickToAdd))
    const toTheLeft = left > sheet.width / 2
    reading.style.left = toTheLeft ? 'auto' : `${left + 12}px`
    reading.style.right = toTheLeft ? `${sheet.width - left + 12}px` : 'auto'
    reading.style.top = `${top + 8}px`
  }

  /** The program in sight. */
  const selected = () => state?.programs.find(({ id }) => id === state?.selected)
  /** What the times would be of now. */
  const subject = () => JSON.stringify([state?.selected, selected()?.dialect, ...sides.map(({ machine }) => machine.motion)])

  /** @param {State} now */
  function show(now) {
    state = now
    offer(beside, [['', say.compare.noOtherMachine], ...form.presets.map(({ name }, index) => [String(index), name])], now.beside === null ? '' : String(now.beside))
    const program = selected()
    const outcome = program?.outcome
    const own = asked(now.machine.values)
    if (!program || !outcome || !own || outcome.motion !== own.motion) {
      root.classList.toggle('stale', Boolean(outcome))
      // Nothing of another program stays in sight.
      root.classList.toggle('bare', !outcome)
      return times.stop()
    }
    root.classList.remove('stale', 'bare')
    const columns = columnsOf(now, program)
    const known = times.of(program, own)
    for (const [column, { summary }] of outcome.runs) known.set(column, summary.cycle_time_s)
    sides = [{ name: String(now.machine.values.name), values: now.machine.values, machine: own, times: known }]
    const other = now.beside === null ? undefined : form.presets[now.beside]
    const machine = other && asked(other.values)
    if (other && machine) sides.push({ name: other.name, values: other.values, machine, times: times.of(program, machine) })

    fill(outcome, columns)
    drawCurves(outcome, columns)
    const isComplete = columns.every((column) => outcome.runs.has(column))
    if (stopped !== subject()) stopped = ''
    const curve = coarseFirst(all)
    const wanted = [...sides.slice(1).map(({ machine }) => ({ machine, columns })), ...sides.map(({ machine }) => ({ machine, columns: curve }))]
    const lacks = wanted.some(({ machine, columns }) => columns.some((column) => !times.of(program, machine).has(column)))
    // The page's own results come first.
    if (now.progress || !isComplete || now.paused) times.stop()
    else if (stopped === '') times.compute(program, wanted, (failure) => (failure ? fail(failure) : whenStill(again)))
    stop.hidden = !lacks
    stop.textContent = stopped === '' ? say.compare.stop : say.compare.computeRest
    standing.textContent = !lacks ? '' : stopped === '' ? say.compare.computing : say.compare.stopped
  }

  function again() {
    if (state) show(state)
  }

  /** @param {string} message */
  function fail(message) {
    stopped = subject()
    again()
    standing.textContent = say.compare.failed(message)
  }

  /** @param {Outcome} outcome @param {Column[]} columns */
  function fill(outcome, columns) {
    const cells = sides.flatMap((side) => columns.map((column, index) => ({ side, column, index, time: side.times.get(column) })))
    const base = cells[0]?.time
    const prices = cells.map(({ side, time }) => (time === undefined ? 0 : (price(side.machine.json, time) ?? 0)))
    const row = (/** @type {string} */ title, /** @type {(cell: typeof cells[number], index: number) => string} */ text, className = '') =>
      make('tr', { className }, make('th', { scope: 'row' }, title), ...cells.map((cell, index) => make('td', {}, cell.time === undefined ? '…' : text(cell, index))))
    const against =
      (/** @type {(by: number, from: number) => string} */ text) =>
      (/** @type {typeof cells[number]} */ { time = 0 }, /** @type {number} */ index) =>
        base === undefined ? '…' : index === 0 ? '–' : text(time - base, base)
    const first = cells[0] ? `${columnLabel(cells[0].column)}${sides.length > 1 ? `, ${sides[0].name}` : ''}` : ''
    const heads = sides.length > 1 ? [make('tr', {}, make('td', {}), ...sides.map(({ name }) => make('th', { scope: 'colgroup', colSpan: columns.length }, name)))] : []
    const labels = cells.map(({ column, index, side }) => make('th', { scope: 'col' }, ...(side === sides[0] ? [make('span', { className: `swatch curve-${index}` })] : []), columnLabel(column)))
    table.replaceChildren(
      make('caption', {}, say.compare.against(first)),
      make('thead', {}, ...heads, make('tr', {}, make('th', { scope: 'col' }, say.common.tolerance), ...labels)),
      make(
        'tbody',
        {},
        row(say.common.cycleTime, ({ time = 0 }) => clock(time), 'time'),
        row(say.compare.inSeconds, ({ time = 0 }) => seconds(time)),
        row(
          say.common.difference,
          against((by) => difference(by)),
        ),
        row(
          say.compare.inPercent,
          against((by, from) => percent(by / from)),
        ),
        ...(prices.some((amount) => amount > 0) ? [row(say.compare.price, (_, index) => (prices[index] > 0 ? money(prices[index]) : '–'), 'price')] : []),
        row(say.compare.againstProgrammed, ({ time = 0 }) => percent(time / outcome.summary.programmed_time_s - 1)),
        row(say.common.contourError, ({ side, column }) => {
          const error = side === sides[0] ? outcome.runs.get(column)?.summary.max_contour_error_mm : undefined
          return error === undefined ? '–' : deviationLabel(error)
        }),
      ),
    )
  }

  /** @param {Outcome} outcome @param {Column[]} columns */
  function drawCurves(outcome, columns) {
    const shown = sides.map((side) => [...side.times].flatMap(([column, time]) => (column === null ? [] : [[column, time]])).sort((a, b) => a[0] - b[0]))
    picture?.free()
    picture = new TolerancePicture(outcome.summary.programmed_time_s)
    for (const rows of shown)
      picture.add(
        Float64Array.from(rows, ([tolerance]) => tolerance),
        Float64Array.from(rows, ([, time]) => time),
      )
    for (const [index, column] of columns.entries()) {
      const time = sides[0].times.get(column)
      if (column !== null && time !== undefined) picture.mark(index, column, time)
    }
    draw()
    const entry = (/** @type {string} */ kind, /** @type {string} */ text) => make('span', {}, make('i', { className: kind }), text)
    legend.replaceChildren(...sides.map(({ name }, index) => entry(index === 0 ? 'line' : 'dashed', name)), entry('programmed', say.compare.programmed))
    const rows = all.map((tolerance) => make('tr', {}, make('th', { scope: 'row' }, deviationLabel(tolerance)), ...sides.map((side) => make('td', {}, written(side.times.get(tolerance))))))
    const heads = [say.common.tolerance, ...sides.map(({ name }) => name)].map((title) => make('th', { scope: 'col' }, title))
    points.replaceChildren(make('thead', {}, make('tr', {}, ...heads)), make('tbody', {}, ...rows))
  }

  return { update: show }
}

/** @param {number | undefined} time */
const written = (time) => (time === undefined ? '…' : seconds(time))
