// One chart on its canvas: forwards pixels, keys and sizes to Rust, which draws and knows the scales. All charts of
// the page have one cursor and one stretch of the path in sight.

import { find, make } from './dom.js'
import { sheetOf, whenStill } from './drawing.js'
import { offerPictures } from './pictures.js'
import { surround } from './plot_around.js'
import { byPointer, pixelOf } from './plot_pointer.js'
import { offerShortcuts } from './shortcuts.js'
import { say } from './texts.js'
import { zoomByWheel } from './wheel.js'
import { whole } from './whole.js'

/** @import { Operation, Place } from "./types.js" */
/** @import { Pointer } from "./pkg/truefeed.js" */
/** @import { Chart as WholeChart } from "./pkg/truefeed_whole.js" */

/** A chart of either module. @typedef {Chart | WholeChart} Filled */
/** @typedef {import("./pkg/truefeed.js").Chart} Chart */

const ZOOM = 1.6
const STEP = 0.2
/** Between the read-out and the corner that it stands in, pixels. */
const GAP_PX = 8

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
    span: () =>
      others()
        .find((other) => other.isShown())
        ?.span(),
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
 * @param {() => Operation[]} [content.operations]  of the program, in order
 * @returns {Plot}
 */
export function mountPlot(root, chart, { isShown, words, fill, chosen, operations = () => [] }) {
  const plot = find(root, '.plot')
  const canvas = /** @type {HTMLCanvasElement} */ (find(root, 'canvas'))
  const cross = find(root, '.cross')
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
    around.hideIn(twin)
    twin.setView(chart.view())
    const answer = ask(twin)
    twin.free()
    return answer
  }
  offerShortcuts(find(root, '.tools'), plot, say.charts.keys)
  offerPictures(find(root, '.tools'), root.id || 'chart', title, () => inSight((twin) => twin.svgInSight(sheet.width, sheet.height)))

  const around = surround(plot, chart, { isShown, operations, changed: () => redraw(), moved: () => moved() })

  const behind = make('details', { className: 'behind' }, make('summary', {}, say.charts.asTable))
  find(root, '.overview').after(behind)
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
    around.drawn()
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
  zoomByWheel(plot, isShown, (factor, event) => {
    chart.zoom(factor, pixelOf(plot, event).x)
    moved()
  })
  plot.addEventListener('dblclick', () => {
    chart.reset()
    moved()
  })
  byPointer(plot, chart, { isShown, read, leave, moved, chosen: (x) => choose(chart.at(x)) })
  plot.addEventListener('pointerleave', (event) => event.pointerType !== 'touch' && leave())
  plot.addEventListener('blur', leave)
  dark.addEventListener('change', () => {
    chart.setDark(dark.matches)
    redraw()
    around.redraw()
  })

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
      ...pointer.curves.map(({ y, index }) => {
        const dot = make('span', { className: `dot curve-${index}` })
        dot.style.top = `${y - top}px`
        return dot
      }),
    )
    reading.hidden = passive
    if (passive) return
    reading.replaceChildren(...words(pointer))
    // In the corner that is away from the pointer, whatever it points at.
    const toTheLeft = pointer.x > (left + right) / 2
    reading.style.left = toTheLeft ? `${left + GAP_PX}px` : 'auto'
    reading.style.right = toTheLeft ? 'auto' : `${sheet.width - right + GAP_PX}px`
    reading.style.top = `${top + GAP_PX}px`
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
      around.filled()
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
