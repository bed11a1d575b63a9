// One chart on its canvas: forwards pixels, keys and sizes to Rust, which draws and knows the scales. All charts of
// the page have one cursor and one stretch of the path in sight.

import { find, make } from './dom.js'
import { sheetOf, whenStill } from './drawing.js'
import { offerPictures } from './pictures.js'
import { say } from './texts.js'
import { whole } from './whole.js'

/** @import { Place } from "./types.js" */
/** @import { Chart, Pointer } from "./pkg/truefeed.js" */
/** @import { Chart as WholeChart } from "./pkg/truefeed_whole.js" */

/** A chart of either module. @typedef {Chart | WholeChart} Filled */

const WHEEL = 1.0015
const ZOOM = 1.6
const STEP = 0.2
const CLICK_PX = 4

/**
 * @typedef {object} Plot
 * @property {() => boolean} isShown
 * @property {() => void} redraw
 * @property {() => void} hide  takes the cursor away
 * @property {(place: Pick<Place, 'distance_mm'>) => void} show  shows a place and takes the keys
 * @property {(stretch: [number, number]) => void} reveal  shows a stretch, mm
 * @property {(anew: boolean) => void} fit  shows the whole of a new path, or what the other charts show
 * @property {(from: number, to: number) => void} follow
 * @property {(distance: number) => void} point
 * @property {() => [number, number]} span
 */

/** @type {Set<Plot>} */
const plots = new Set()

/**
 * What has the cursor of the charts but no distance axis: the path, the program text.
 * @typedef {object} Linked
 * @property {(distance: number) => void} point  shows the cursor
 * @property {() => void} hide  takes it away
 * @property {(distance: number) => void} choose  keeps a place that was clicked on
 */

/** @type {Set<Linked>} */
const linked = new Set()

/** Moves something with the charts; what is returned moves them and all else. @param {Linked} own @returns {Linked} */
export function link(own) {
  linked.add(own)
  const others = () => [...linked].filter((other) => other !== own)
  return {
    point(distance) {
      for (const other of [...plots, ...others()]) other.point(distance)
    },
    hide() {
      for (const other of [...plots, ...others()]) other.hide()
    },
    choose(distance) {
      for (const other of others()) other.choose(distance)
    },
  }
}

/**
 * Gives a picture that draws itself the cursor and the stretch of the path that all charts have.
 * @param {Plot} plot
 * @returns {{point(distance: number): void, leave(): void, span(): [number, number] | undefined}}
 */
export function join(plot) {
  plots.add(plot)
  const others = () => [...plots].filter((other) => other !== plot)
  return {
    point: (distance) => [...others(), ...linked].forEach((other) => other.point(distance)),
    leave: () => [...others(), ...linked].forEach((other) => other.hide()),
    span: () => others().find((other) => other.isShown())?.span(),
  }
}

/**
 * @param {HTMLElement} root
 * @param {Chart} chart
 * @param {object} content
 * @param {() => boolean} content.isShown  whether there is something to draw
 * @param {(pointer: Pointer) => Node[]} content.words  what the read-out says
 * @param {(chart: Filled) => void} content.fill  puts into a new chart what this one shows
 * @param {(pointer: Pointer) => void} [content.chosen]  a place was clicked on
 * @returns {Plot}
 */
export function mountPlot(root, chart, { isShown, words, fill, chosen }) {
  const plot = find(root, '.plot')
  const canvas = /** @type {HTMLCanvasElement} */ (find(root, 'canvas'))
  const cross = find(root, '.cross')
  const box = find(root, '.box')
  const reading = find(root, '.reading')
  const rapids = find(root, '.rapids')
  const rapidsBox = /** @type {HTMLInputElement} */ (find(rapids, 'input'))
  const dark = window.matchMedia('(prefers-color-scheme: dark)')

  const title = plot.getAttribute('aria-label') ?? say.charts.picture
  /** Asks the whole module about what is in sight: that of the first visit draws on no paper and makes no table. @template T @param {(twin: WholeChart) => T} ask */
  async function inSight(ask) {
    const { Chart } = await whole()
    const twin = new Chart()
    fill(twin)
    twin.setView(chart.view())
    const answer = ask(twin)
    twin.free()
    return answer
  }
  offerPictures(find(root, '.tools'), root.id || 'chart', title, () => inSight((twin) => twin.svgInSight(sheet.width, sheet.height)))

  const behind = make('details', { className: 'behind' }, make('summary', {}, say.charts.asTable))
  plot.after(behind)
  behind.addEventListener('toggle', tabulate)
  /** Puts what is in sight into the table, where that is open. */
  async function tabulate() {
    if (!behind.open || !isShown()) return
    const { tableOf } = await import('./table.js')
    const table = await inSight((twin) => tableOf(twin, title))
    behind.replaceChildren(behind.children[0], table)
  }

  let readAt = NaN
  /** Whether the pointer is on another chart. */
  let isPassive = false

  const sheet = sheetOf(canvas, () => {
    if (!isShown()) return
    chart.setDark(dark.matches)
    chart.draw(canvas, sheet.width, sheet.height, sheet.ratio())
    plot.dataset.span = chart.span().join(' ')
    if (Number.isFinite(readAt)) show(chart.reading(readAt), isPassive)
    whenStill(tabulate)
  })
  const { redraw } = sheet

  /** Draws anew after a change of the view, and all other charts with it. */
  function moved() {
    sheet.moved()
    const [from, to] = chart.span()
    for (const other of plots) if (other !== own) other.follow(from, to)
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

  for (const button of /** @type {NodeListOf<HTMLElement>} */ (root.querySelectorAll('[data-do]'))) {
    button.addEventListener('click', () => {
      verbs[/** @type {keyof typeof verbs} */ (button.dataset.do)]()
      moved()
    })
  }
  rapidsBox.addEventListener('change', () => {
    chart.setRapids(rapidsBox.checked)
    moved()
  })
  plot.addEventListener('keydown', (event) => {
    if (!isShown() || event.ctrlKey || event.metaKey || event.altKey) return
    if (event.shiftKey && event.key.startsWith('Arrow')) {
      event.preventDefault()
      return walk(event.key === 'ArrowLeft' || event.key === 'ArrowDown' ? -1 : 1)
    }
    if (event.key === 'Escape') return leave()
    if (event.key === 'Enter' && Number.isFinite(readAt)) return choose(chart.reading(readAt))
    const verb = KEYS[event.key]
    if (!verb) return
    event.preventDefault()
    verbs[verb]()
    moved()
  })
  plot.addEventListener(
    'wheel',
    (event) => {
      if (!isShown()) return
      event.preventDefault()
      chart.zoom(WHEEL ** -event.deltaY, pixel(event).x)
      moved()
    },
    { passive: false },
  )
  plot.addEventListener('dblclick', () => {
    chart.reset()
    moved()
  })
  /** Where each finger is. @type {Map<number, {x: number, y: number}>} */
  const fingers = new Map()
  let isPinched = false
  plot.addEventListener('pointerdown', (event) => {
    if (!isShown() || event.button !== 0) return
    if (event.pointerType === 'touch') fingers.set(event.pointerId, pixel(event))
    isPinched = fingers.size > 1
    if (isPinched) plot.setPointerCapture(event.pointerId)
    else drag(event)
  })
  plot.addEventListener('pointermove', (event) => {
    if (event.buttons === 0) return isShown() && read(pixel(event).x)
    const own = fingers.get(event.pointerId)
    const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1]
    if (!own || !other) return
    const now = pixel(event)
    const apart = (/** @type {{x: number, y: number}} */ { x, y }) => Math.max(Math.hypot(x - other.x, y - other.y), 1)
    chart.pan((now.x - own.x) / 2, 0)
    chart.zoom(apart(now) / apart(own), (now.x + other.x) / 2)
    fingers.set(event.pointerId, now)
    moved()
  })
  for (const end of ['pointerup', 'pointercancel'])
    plot.addEventListener(end, (event) => fingers.delete(/** @type {PointerEvent} */ (event).pointerId))
  plot.addEventListener('pointerleave', (event) => event.pointerType !== 'touch' && leave())
  plot.addEventListener('blur', leave)
  dark.addEventListener('change', redraw)

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
    leave()
    const clamp = ({ x = 0, y = 0 }) => ({
      x: Math.min(Math.max(x, left), right),
      y: Math.min(Math.max(y, top), bottom),
    })

    /** A flat box, or one among the contour errors, is meant as a stretch of the path. */
    const flat = () => isBelow || Math.abs(last.y - from.y) < 3 * CLICK_PX

    const move = (/** @type {PointerEvent} */ event) => {
      if (event.pointerId !== start.pointerId) return
      const to = pixel(event)
      if (moves) {
        if (fingers.size < 2) {
          chart.pan(to.x - last.x, isBelow ? 0 : to.y - last.y)
          moved()
        }
        last = to
        return
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
      if (event.pointerId !== start.pointerId) return
      plot.removeEventListener('pointermove', move)
      plot.removeEventListener('pointerup', end)
      plot.removeEventListener('pointercancel', end)
      box.hidden = true
      const isClick = Math.abs(last.x - from.x) < CLICK_PX && event.type !== 'pointercancel' && !isPinched
      if (isClick && !start.shiftKey && left <= from.x && from.x <= right) choose(chart.at(from.x))
      if (start.pointerType === 'touch' && isClick) return read(from.x)
      if (moves || event.type === 'pointercancel' || isClick) return
      const [y0, y1] = flat() ? [top, bottom] : [from.y, last.y]
      chart.zoomTo(from.x, y0, last.x, y1)
      moved()
    }
    plot.addEventListener('pointermove', move)
    plot.addEventListener('pointerup', end)
    plot.addEventListener('pointercancel', end)
  }

  /** @param {number} x */
  function read(x) {
    const [left, right] = chart.area()
    if (x < left || right < x) return leave()
    show(chart.at(x), false)
    if (!Number.isFinite(readAt)) return
    for (const other of plots) if (other !== own) other.point(readAt)
    for (const other of linked) other.point(readAt)
  }

  /** Reads along the path by keys. @param {number} direction */
  function walk(direction) {
    const [left, right] = chart.area()
    const here = Number.isFinite(readAt) ? (chart.reading(readAt)?.x ?? left) : (left + right) / 2
    read(Math.min(Math.max(here + direction * 4, left), right))
  }

  /** Takes the cursor out of all charts. */
  function leave() {
    for (const other of [...plots, ...linked]) other.hide()
  }

  /** @param {Pointer | undefined} pointer */
  function choose(pointer) {
    if (!pointer) return
    chosen?.(pointer)
    for (const other of linked) other.choose(pointer.distance)
  }

  function hide() {
    readAt = NaN
    cross.hidden = true
    reading.hidden = true
  }

  /** @param {Pointer | undefined} pointer @param {boolean} passive */
  function show(pointer, passive) {
    if (!pointer) return hide()
    const [left, right, top, , , lowest] = chart.area()
    if (pointer.x < left - 1 || right + 1 < pointer.x) return hide()
    readAt = pointer.distance
    isPassive = passive
    cross.hidden = false
    Object.assign(cross.style, { left: `${pointer.x}px`, top: `${top}px`, height: `${lowest - top}px` })
    cross.replaceChildren(
      ...pointer.curves.map(({ y }, index) => {
        const dot = make('span', { className: `dot curve-${index}` })
        dot.style.top = `${y - top}px`
        return dot
      }),
    )
    reading.hidden = passive
    if (passive) return
    reading.replaceChildren(...words(pointer))
    const toTheLeft = pointer.x > (left + right) / 2
    reading.style.left = toTheLeft ? 'auto' : `${pointer.x + 12}px`
    reading.style.right = toTheLeft ? `${sheet.width - pointer.x + 12}px` : 'auto'
    reading.style.top = `${top + 8}px`
  }

  /** @type {Plot} */
  const own = {
    isShown,
    redraw,
    hide,
    show({ distance_mm: [from, to] }) {
      own.reveal([from, to])
      root.scrollIntoView({ block: 'nearest' })
      plot.focus({ preventScroll: true })
    },
    reveal([from, to]) {
      chart.show(from, to)
      moved()
    },
    fit(anew) {
      chart.fit(anew)
      const other = [...plots].find((candidate) => candidate !== own && candidate.isShown())
      if (anew && other) chart.follow(...other.span())
      rapids.hidden = !chart.hidesRapids()
      redraw()
    },
    follow(from, to) {
      if (!isShown()) return
      chart.follow(from, to)
      sheet.moved()
    },
    point(distance) {
      if (isShown()) show(chart.reading(distance), true)
    },
    span: () => /** @type {[number, number]} */ ([...chart.span()]),
  }
  plots.add(own)
  return own
}
