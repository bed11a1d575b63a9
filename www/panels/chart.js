// The chart on its canvas. Rust draws and knows the scales; this forwards pixels, keys and sizes.

import { Chart, deviationLabel, mostCurves } from '../pkg/truefeed.js'
import { columnLabel, columnsOf } from '../columns.js'
import { find, make } from '../dom.js'
import { feedrate, millimetres, clock, seconds } from '../format.js'

/** @import { Held, Outcome, Place, Program, State } from "../types.js" */
/** @import { Pointer } from "../pkg/truefeed.js" */

const WHEEL = 1.0015
const ZOOM = 1.6
const STEP = 0.2
const CLICK_PX = 4
/** plotters draws on whole pixels; twice as many as the page's make slanting lines smooth on any screen. */
const LEAST_RATIO = 2

/** @param {HTMLElement} root */
export function mount(root) {
  const chart = new Chart()
  const plot = find(root, '.plot')
  const canvas = /** @type {HTMLCanvasElement} */ (find(root, 'canvas'))
  const empty = find(root, '.empty')
  const cross = find(root, '.cross')
  const box = find(root, '.box')
  const reading = find(root, '.reading')
  const rapids = find(root, '.rapids')
  const rapidsBox = /** @type {HTMLInputElement} */ (find(rapids, 'input'))
  const dark = window.matchMedia('(prefers-color-scheme: dark)')

  /** @type {Program | undefined} */
  let program
  /** What is in the chart now, so that it is filled anew only when something else is to be shown. @type {unknown[]} */
  let filled = []
  /** @type {Outcome | null | undefined} */
  let outcome
  /** The path that the view fits: its program and its length. @type {string | undefined} */
  let fitted
  let frame = 0
  let readAt = NaN

  function redraw() {
    frame ||= requestAnimationFrame(() => {
      frame = 0
      const { clientWidth: width, clientHeight: height } = canvas
      if (!outcome || width === 0) return
      chart.setDark(dark.matches)
      chart.draw(canvas, width, height, Math.max(window.devicePixelRatio, LEAST_RATIO))
      plot.dataset.span = chart.span().join(' ')
      if (Number.isFinite(readAt)) show(chart.reading(readAt))
    })
  }

  const verbs = {
    in: () => chart.zoom(ZOOM),
    out: () => chart.zoom(1 / ZOOM),
    left: () => chart.step(-STEP, 0),
    right: () => chart.step(STEP, 0),
    up: () => chart.step(0, STEP),
    down: () => chart.step(0, -STEP),
    reset: () => chart.reset(),
  }
  /** @type {Record<string, keyof typeof verbs>} */
  const KEYS = {
    '+': 'in',
    '=': 'in',
    '-': 'out',
    ArrowLeft: 'left',
    ArrowRight: 'right',
    ArrowUp: 'up',
    ArrowDown: 'down',
    Home: 'reset',
    0: 'reset',
  }

  for (const button of root.querySelectorAll('button')) {
    button.addEventListener('click', () => {
      verbs[/** @type {keyof typeof verbs} */ (button.dataset.do)]()
      redraw()
    })
  }
  rapidsBox.addEventListener('change', () => {
    chart.setRapids(rapidsBox.checked)
    redraw()
  })
  plot.addEventListener('keydown', (event) => {
    if (!outcome || event.ctrlKey || event.metaKey || event.altKey) return
    if (event.shiftKey && event.key.startsWith('Arrow')) {
      event.preventDefault()
      return walk(event.key === 'ArrowLeft' || event.key === 'ArrowDown' ? -1 : 1)
    }
    if (event.key === 'Escape') return hide()
    const verb = KEYS[event.key]
    if (!verb) return
    event.preventDefault()
    verbs[verb]()
    redraw()
  })
  plot.addEventListener(
    'wheel',
    (event) => {
      if (!outcome) return
      event.preventDefault()
      chart.zoom(WHEEL ** -event.deltaY, pixel(event).x)
      redraw()
    },
    { passive: false },
  )
  plot.addEventListener('dblclick', () => {
    chart.reset()
    redraw()
  })
  plot.addEventListener('pointerdown', (event) => outcome && event.button === 0 && drag(event))
  plot.addEventListener('pointermove', (event) => event.buttons === 0 && outcome && read(pixel(event).x))
  plot.addEventListener('pointerleave', (event) => event.pointerType !== 'touch' && hide())
  plot.addEventListener('blur', hide)
  new ResizeObserver(redraw).observe(plot)
  dark.addEventListener('change', () => {
    colors()
    redraw()
  })

  /** @param {MouseEvent} event */
  function pixel(event) {
    const { left, top } = plot.getBoundingClientRect()
    return { x: event.clientX - left - plot.clientLeft, y: event.clientY - top - plot.clientTop }
  }

  /** Draws a box to zoom to; with Shift, or on an axis, moves the picture. A touch moves it as well. @param {PointerEvent} start */
  function drag(start) {
    const from = pixel(start)
    const [left, right, top, bottom, , lowest] = chart.area()
    const onAxis = from.x < left || from.y > lowest
    const isBelow = from.y > bottom
    const moves = start.shiftKey || onAxis || start.pointerType === 'touch'
    let last = from
    plot.setPointerCapture(start.pointerId)
    hide()
    const clamp = ({ x = 0, y = 0 }) => ({
      x: Math.min(Math.max(x, left), right),
      y: Math.min(Math.max(y, top), bottom),
    })

    /** A flat box, or one among the contour errors, is meant as a stretch of the path. */
    const flat = () => isBelow || Math.abs(last.y - from.y) < 3 * CLICK_PX

    const move = (/** @type {PointerEvent} */ event) => {
      const to = pixel(event)
      if (moves) {
        chart.pan(to.x - last.x, isBelow ? 0 : to.y - last.y)
        last = to
        return redraw()
      }
      last = clamp(to)
      const [y0, y1] = flat() ? [top, lowest] : [from.y, last.y]
      box.hidden = false
      Object.assign(box.style, {
        left: `${Math.min(from.x, last.x)}px`,
        top: `${Math.min(y0, y1)}px`,
        width: `${Math.abs(last.x - from.x)}px`,
        height: `${Math.abs(y1 - y0)}px`,
      })
    }
    const end = (/** @type {PointerEvent} */ event) => {
      plot.removeEventListener('pointermove', move)
      plot.removeEventListener('pointerup', end)
      plot.removeEventListener('pointercancel', end)
      box.hidden = true
      if (start.pointerType === 'touch' && Math.abs(last.x - from.x) < CLICK_PX) return read(from.x)
      if (moves || event.type === 'pointercancel' || Math.abs(last.x - from.x) < CLICK_PX) return
      const [y0, y1] = flat() ? [top, bottom] : [from.y, last.y]
      chart.zoomTo(from.x, y0, last.x, y1)
      redraw()
    }
    plot.addEventListener('pointermove', move)
    plot.addEventListener('pointerup', end)
    plot.addEventListener('pointercancel', end)
  }

  /** @param {number} x */
  function read(x) {
    const [left, right] = chart.area()
    if (x < left || right < x) return hide()
    show(chart.at(x))
  }

  /** Reads along the path by keys. @param {number} direction */
  function walk(direction) {
    const [left, right] = chart.area()
    const here = Number.isFinite(readAt) ? (chart.reading(readAt)?.x ?? left) : (left + right) / 2
    read(Math.min(Math.max(here + direction * 4, left), right))
  }

  function hide() {
    readAt = NaN
    cross.hidden = true
    reading.hidden = true
  }

  /** @param {Pointer | undefined} pointer */
  function show(pointer) {
    if (!pointer) return hide()
    const [left, right, top, , , lowest] = chart.area()
    if (pointer.x < left - 1 || right + 1 < pointer.x) return hide()
    readAt = pointer.distance
    cross.hidden = false
    Object.assign(cross.style, { left: `${pointer.x}px`, top: `${top}px`, height: `${lowest - top}px` })
    cross.replaceChildren(
      ...pointer.curves.map(({ y }, index) => {
        const dot = make('span', { className: `dot curve-${index}` })
        dot.style.top = `${y - top}px`
        return dot
      }),
    )
    reading.hidden = false
    reading.replaceChildren(...words(pointer, program))
    const toTheLeft = pointer.x > (left + right) / 2
    reading.style.left = toTheLeft ? 'auto' : `${pointer.x + 12}px`
    reading.style.right = toTheLeft ? `${plot.clientWidth - pointer.x + 12}px` : 'auto'
    reading.style.top = `${top + 8}px`
  }

  /** Adds the curve of the program's own tolerances. @param {Held[]} held */
  function addProgrammed(held) {
    const part = (/** @type {(part: Held) => number} */ of) => Float64Array.from(held, of)
    chart.addProgrammed(
      columnLabel(null),
      part(({ distance_mm: [from] }) => from),
      part(({ distance_mm: [, to] }) => to),
      part(({ tolerance_mm: tolerance }) => tolerance),
    )
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
    show({ distance_mm: [from, to] }) {
      chart.show(from, to)
      redraw()
      root.scrollIntoView({ block: 'nearest' })
      plot.focus({ preventScroll: true })
    },
    /** @param {State} state */
    update(state) {
      program = state.programs.find(({ id }) => id === state.selected)
      outcome = program?.outcome
      const columns = columnsOf(state, outcome)
      const runs = columns.filter((column) => outcome?.runs.has(column))
      empty.hidden = Boolean(outcome)
      empty.textContent = state.progress ? 'Computing …' : 'Not computed yet.'
      canvas.hidden = !outcome
      root.classList.toggle('stale', Boolean(outcome) && outcome?.motion !== state.machine.motion)
      const fill = [program, outcome, ...columns, ...runs]
      if (fill.length === filled.length && fill.every((value, index) => value === filled[index])) return
      filled = fill
      hide()
      if (!outcome) return
      const { end, feedrate, rapid, line } = outcome.steps
      chart.program(end, feedrate, rapid, line)
      for (const column of columns) {
        if (column === null) addProgrammed(outcome.held)
        else chart.add(column)
        const curve = outcome.runs.get(column)?.columns
        if (curve) chart.fill(curve.distance, curve.feedrate, curve.time, curve.corner, curve.arc)
      }
      // A path of another length has no use for the view of the former one.
      const path = `${program?.id} ${end.at(-1)}`
      chart.fit(fitted !== path)
      fitted = path
      rapids.hidden = !chart.hidesRapids()
      redraw()
    },
  }
}

/** What the chart says about one distance. @param {Pointer} pointer @param {Program | undefined} program */
function words({ distance, line, programmed, rapid, curves }, program) {
  const rows = curves.map(({ label, feedrate: feed, time, error }, index) =>
    make(
      'tr',
      {},
      make('th', { scope: 'row' }, make('span', { className: `swatch curve-${index}` }), label),
      make('td', {}, feedrate(feed)),
      make('td', {}, error === undefined ? '–' : `${deviationLabel(error)} off`),
      make('td', {}, time < 60 ? seconds(time) : clock(time)),
    ),
  )
  const head = make(
    'p',
    {},
    make('strong', {}, millimetres(distance)),
    programmed === undefined ? '' : ` · ${rapid ? 'rapid' : 'programmed'} ${feedrate(programmed)}`,
  )
  const text = line === undefined ? '' : (program?.lines()[line - 1] ?? '')
  const code = line === undefined ? [] : [make('p', { className: 'code' }, `line ${line} `, make('code', {}, text))]
  return [head, make('table', {}, ...rows), ...code]
}
