// The path in space beside its program text, and the places that cost most; all linked with the charts.

import { PathView } from '../pkg/truefeed_whole.js'
import { columnLabel, columnsOf } from '../columns.js'
import { find, make } from '../dom.js'
import { sheetOf } from '../drawing.js'
import { count, feedrate, figures, millimetres, number, percent, worded } from '../format.js'
import { mountListing } from '../listing.js'
import { offerPictures } from '../pictures.js'
import { link } from '../plot.js'
import { recordingOf } from '../recordings.js'
import { say } from '../texts_later.js'
import { lineOf } from './chart.js'

/** @import { Column, LostAt, MatchedColumns, Outcome, Program, Run, State } from "../types.js" */

const WHEEL = 1.0015
const ZOOM = 1.5
const STEP_PX = 60
const STEP_RAD = 0.12
const RAD_PER_PX = 0.008
const WALK_PX = 6
const CLICK_PX = 4
const AXIS_PX = 26
const MOST_PIXELS = 3e6

const COLORS = /** @type {const} */ ([
  ['feedrate', say.path.byFeedrate, say.common.feedrate],
  ['loss', say.path.byLoss, say.path.loss],
  ['lost', say.path.byLost, say.path.lost],
])

/**
 * @param {HTMLElement} root
 * @param {{reveal(stretch: [number, number]): void}} actions
 */
export function mount(root, actions) {
  const space = find(root, '.space')
  const canvas = /** @type {HTMLCanvasElement} */ (find(root, 'canvas'))
  const by = /** @type {HTMLSelectElement} */ (find(root, '.by'))
  const at = /** @type {HTMLSelectElement} */ (find(root, '.at'))
  const [marks, axes, scale, here, reading, legend, list] = ['.marks', '.axes', '.scale', '.here', '.reading', '.legend', '.places'].map(
    (selector) => find(root, selector),
  )
  const looks = /** @type {NodeListOf<HTMLElement>} */ (root.querySelectorAll('[data-look]'))
  const dark = window.matchMedia('(prefers-color-scheme: dark)')
  const view = new PathView()
  const listing = mountListing(find(root, '.listing'), {
    chosen(line) {
      const stretch = view.stretchOf(line)
      if (stretch.length === 0) return
      keep([stretch[0], stretch[1]])
      showAt(0.5 * (stretch[0] + stretch[1]), false)
      others.point(readAt)
    },
    pointed(line) {
      const stretch = line === null ? [] : view.stretchOf(line)
      if (stretch.length === 0) return leave()
      showAt(0.5 * (stretch[0] + stretch[1]), false)
      others.point(readAt)
    },
  })
  const others = link({
    point: (distance) => {
      if (!sheet.isInSight || !outcome) return
      showAt(distance, false)
      listing.point(view.lineAt(distance) ?? 0)
    },
    hide: () => hide(),
    choose: (distance) => {
      // Where it has not been in sight so far, it knows nothing of the program yet.
      fill()
      const line = view.lineAt(distance)
      if (line !== undefined) chooseLine(line)
    },
  })

  offerPictures(find(root, '.tools'), 'path', say.path.picture, () => {
    const [length] = view.scale()
    return outcome ? view.svg(...ends(), lengthLabel(length)) : undefined
  })

  /** @type {Program | undefined} */
  let program
  /** @type {Outcome | null | undefined} */
  let outcome
  /** @type {Column[]} */
  let columns = []
  /** @type {Run | undefined} */
  let run
  /** @type {MatchedColumns | undefined} */
  let lost
  /** What the picture shows now, so that it is made anew only when something else is to be shown. @type {unknown[]} */
  let filled = []
  /** @type {string | undefined} */
  let fitted
  /** @type {Program | undefined} */
  let listed
  let look = 'top'
  let readAt = NaN
  /** @type {LostAt | undefined} */
  let chosenPlace

  // Drawing

  const sheet = sheetOf(canvas, () => {
    fill()
    if (!outcome) return
    const { width, height } = sheet
    // While it moves the page's own pixels do: it has no letters.
    view.draw(canvas, width, height, Math.min(sheet.ratio(1), Math.sqrt(MOST_PIXELS / (width * height))))
    overlay(height)
  }, root)
  const { redraw, moved } = sheet

  /** Places what lies over the picture. @param {number} height */
  function overlay(height) {
    for (const mark of /** @type {Iterable<HTMLElement>} */ (marks.children)) put(mark, Number(mark.dataset.at))
    if (!here.hidden) put(here, readAt)
    const directions = view.axes()
    const [left, bottom] = [AXIS_PX + 14, height - AXIS_PX - 14]
    axes.replaceChildren(
      ...['X', 'Y', 'Z'].flatMap((name, index) => {
        const [x, y] = directions.subarray(2 * index, 2 * index + 2)
        const size = Math.hypot(x, y) * AXIS_PX
        if (size < 6) return []
        const shaft = make('i', {})
        Object.assign(shaft.style, { left: `${left}px`, top: `${bottom}px`, width: `${size}px`, transform: `rotate(${Math.atan2(y, x)}rad)` })
        const label = make('span', {}, name)
        const far = AXIS_PX * (1 + 10 / size)
        Object.assign(label.style, { left: `${left + x * far}px`, top: `${bottom + y * far}px` })
        return [shaft, label]
      }),
    )
    const [length, width] = view.scale()
    scale.style.width = `${width}px`
    scale.textContent = lengthLabel(length)
  }

  /** @param {HTMLElement} element @param {number} distance */
  function put(element, distance) {
    const [x, y] = view.locate(distance)
    Object.assign(element.style, { left: `${x}px`, top: `${y}px` })
  }

  // The cursor

  /** @param {number} distance @param {boolean} withWords */
  function showAt(distance, withWords) {
    readAt = distance
    here.hidden = false
    put(here, distance)
    reading.hidden = !withWords
    if (!withWords) return
    const runs = view.feedrateAt(distance)
    const fast = runs === undefined ? '' : ` · ${feedrate(runs)}`
    reading.replaceChildren(make('p', {}, make('strong', {}, millimetres(distance)), fast), ...lineOf(view.lineAt(distance), program))
    const [x, y] = view.locate(distance)
    const toTheLeft = x > sheet.width / 2
    const above = y > sheet.height / 2
    Object.assign(reading.style, {
      left: toTheLeft ? 'auto' : `${x + 14}px`,
      right: toTheLeft ? `${sheet.width - x + 14}px` : 'auto',
      top: above ? 'auto' : `${y + 10}px`,
      bottom: above ? `${sheet.height - y + 10}px` : 'auto',
    })
  }

  function hide() {
    readAt = NaN
    here.hidden = true
    reading.hidden = true
    listing.point(0)
  }

  function leave() {
    hide()
    others.hide()
  }

  /** @param {number} distance */
  function read(distance) {
    showAt(distance, true)
    listing.point(view.lineAt(distance) ?? 0)
    others.point(distance)
  }

  /** Marks a stretch of the path. @param {[number, number]} stretch */
  function keep([from, to]) {
    view.mark(from, to)
    view.reveal(0.5 * (from + to))
    setPlace(undefined)
    moved()
  }

  /** Marks the path of a line, and the line. @param {number} line */
  function chooseLine(line) {
    const stretch = view.stretchOf(line)
    if (stretch.length > 0) keep([stretch[0], stretch[1]])
    listing.choose(line)
  }

  /** @param {number} distance */
  function choose(distance) {
    const line = view.lineAt(distance)
    if (line !== undefined) chooseLine(line)
    read(distance)
    others.choose(distance)
  }

  /** @param {LostAt} place */
  function choosePlace(place) {
    const [from, to] = place.distance_mm
    keep([from, to])
    setPlace(place)
    listing.choose(place.lines[0])
    actions.reveal([from, to])
    const middle = 0.5 * (from + to)
    showAt(middle, false)
    others.point(middle)
  }

  /** @param {LostAt | undefined} place */
  function setPlace(place) {
    chosenPlace = place
    const index = run?.summary.lost.places.findIndex((other) => other === place) ?? -1
    for (const [row, element] of [...list.querySelectorAll('tbody tr')].entries()) {
      if (row === index) element.setAttribute('aria-current', 'true')
      else element.removeAttribute('aria-current')
    }
    for (const [row, element] of [...marks.children].entries()) element.classList.toggle('chosen', row === index)
  }

  // The view

  /** @param {string} from */
  function lookFrom(from) {
    look = from
    view.resize(sheet.width, sheet.height)
    view.look(from)
    for (const button of looks) button.setAttribute('aria-pressed', String(button.dataset.look === from))
    moved()
  }

  /** @param {number} factor @param {{x: number, y: number}} [about] */
  function zoom(factor, about = middle()) {
    view.zoom(factor, about.x, about.y)
    moved()
  }

  /** What keys magnify about: the cursor, or the middle. */
  function middle() {
    const { width, height } = sheet
    const [x, y] = here.hidden ? [] : view.locate(readAt)
    return 0 <= x && x <= width && 0 <= y && y <= height ? { x, y } : { x: width / 2, y: height / 2 }
  }

  /** @param {number} right @param {number} up */
  function step(right, up) {
    if (look === 'turned') view.turn(right * STEP_RAD, up * STEP_RAD)
    else view.pan(-right * STEP_PX, up * STEP_PX)
    moved()
  }

  const verbs = {
    in: () => zoom(ZOOM),
    out: () => zoom(1 / ZOOM),
    fit: () => {
      view.fit()
      moved()
    },
  }
  /** @type {Record<string, () => void>} */
  const KEYS = {
    '+': verbs.in,
    '=': verbs.in,
    '-': verbs.out,
    Home: () => lookFrom(look),
    0: () => lookFrom(look),
    ArrowLeft: () => step(-1, 0),
    ArrowRight: () => step(1, 0),
    ArrowUp: () => step(0, 1),
    ArrowDown: () => step(0, -1),
  }

  for (const button of looks) button.addEventListener('click', () => lookFrom(button.dataset.look ?? 'top'))
  for (const button of /** @type {NodeListOf<HTMLElement>} */ (root.querySelectorAll('[data-do]')))
    button.addEventListener('click', () => verbs[/** @type {keyof typeof verbs} */ (button.dataset.do)]())
  for (const select of [by, at]) select.addEventListener('change', refill)

  space.addEventListener('keydown', (event) => {
    if (!outcome || event.ctrlKey || event.metaKey || event.altKey) return
    if (event.shiftKey && event.key.startsWith('Arrow')) {
      event.preventDefault()
      return walk(event.key === 'ArrowLeft' || event.key === 'ArrowDown' ? -1 : 1)
    }
    if (event.key === 'Escape') return leave()
    if (event.key === 'Enter' && Number.isFinite(readAt)) return choose(readAt)
    const verb = KEYS[event.key]
    if (!verb) return
    event.preventDefault()
    verb()
  })

  /** Reads along the path by keys. @param {number} direction */
  function walk(direction) {
    const [length, width] = view.scale()
    const from = Number.isFinite(readAt) ? readAt : 0
    read(Math.min(Math.max(from + (direction * WALK_PX * length) / width, 0), view.length()))
  }

  space.addEventListener(
    'wheel',
    (event) => {
      if (!outcome) return
      event.preventDefault()
      zoom(WHEEL ** -event.deltaY, pixel(event))
    },
    { passive: false },
  )
  space.addEventListener('dblclick', () => lookFrom(look))
  space.addEventListener('pointerleave', (event) => event.pointerType !== 'touch' && leave())
  space.addEventListener('blur', leave)
  space.addEventListener('contextmenu', (event) => event.preventDefault())

  /** @param {MouseEvent} event */
  function pixel(event) {
    const { left, top } = space.getBoundingClientRect()
    return { x: event.clientX - left - space.clientLeft, y: event.clientY - top - space.clientTop }
  }

  /** Where each finger or button is, and whether it has moved. @type {Map<number, {x: number, y: number, begun: {x: number, y: number}}>} */
  const pointers = new Map()
  let hasDragged = false

  space.addEventListener('pointerdown', (event) => {
    if (!outcome) return
    const now = pixel(event)
    if (pointers.size === 0) hasDragged = false
    pointers.set(event.pointerId, { ...now, begun: now })
    space.setPointerCapture(event.pointerId)
  })
  space.addEventListener('pointermove', (event) => {
    if (!outcome) return
    const now = pixel(event)
    const own = pointers.get(event.pointerId)
    if (!own) {
      if (event.buttons !== 0) return
      const distance = view.pick(now.x, now.y)
      return distance === undefined ? leave() : read(distance)
    }
    if (!hasDragged && Math.hypot(now.x - own.begun.x, now.y - own.begun.y) < CLICK_PX) return
    if (!hasDragged) leave()
    hasDragged = true
    const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1]
    const [dx, dy] = [now.x - own.x, now.y - own.y]
    if (other) {
      const apart = (/** @type {{x: number, y: number}} */ { x, y }) => Math.max(Math.hypot(x - other.x, y - other.y), 1)
      view.pan(dx / 2, dy / 2)
      view.zoom(apart(now) / apart(own), (now.x + other.x) / 2, (now.y + other.y) / 2)
    } else if (look === 'turned' && !event.shiftKey && (event.buttons & 1) === 1) {
      view.turn(-dx * RAD_PER_PX, dy * RAD_PER_PX)
    } else view.pan(dx, dy)
    Object.assign(own, now)
    moved()
  })
  for (const end of /** @type {const} */ (['pointerup', 'pointercancel'])) {
    space.addEventListener(end, (event) => {
      const own = pointers.get(event.pointerId)
      pointers.delete(event.pointerId)
      if (!own || hasDragged || end === 'pointercancel') return
      const distance = view.pick(own.x, own.y)
      if (distance !== undefined) choose(distance)
    })
  }
  dark.addEventListener('change', () => {
    filled = []
    refill()
  })

  // Filling

  /** Shows what is to be shown now, where it is in sight. */
  function refill() {
    if (sheet.isInSight) fill()
    redraw()
  }

  function fill() {
    if (!outcome) return
    const column = columns[at.selectedIndex]
    run = outcome.runs.get(column)
    const now = [outcome, run, lost, by.value]
    if (now.length === filled.length && now.every((value, index) => value === filled[index])) return
    const isOther = filled[0] !== outcome
    filled = now
    if (isOther) {
      const { end, feedrate: feed, rapid, line } = outcome.steps
      view.program(outcome.trail.points, outcome.trail.distance, end, feed, rapid, line)
      hide()
    }
    view.setDark(dark.matches)
    if (run) view.pace(run.columns.paceEnd, run.columns.paceFeedrate)
    if (lost) view.lost(lost.lostDistance, lost.lostSeconds)
    view.color(by.value)
    if (listed !== program && program) listing.fill(program.lines)
    listed = program
    const path = `${program?.id} ${outcome.steps.end.at(-1)}`
    if (fitted !== path) lookFrom(look)
    fitted = path
    fillLegend()
    fillPlaces(column)
    const way = COLORS.find(([value]) => value === by.value)?.[1]
    canvas.setAttribute('aria-label', say.path.described(program?.name, way))
  }

  /** What the first and the last colour stand for. @returns {[string, string]} */
  function ends() {
    const { ends, unit } = view.legend()
    const [first, last] = [...ends].map((end) => `${unit === 'mm/min' ? count(end) : number(end)} ${unit}`)
    return [first, last]
  }

  function fillLegend() {
    const { colors } = view.legend()
    const title = COLORS.find(([value]) => value === by.value)?.[2] ?? ''
    const ramp = make(
      'span',
      { className: 'ramp' },
      ...colors.map((color) => {
        const swatch = make('span', {})
        swatch.style.background = color
        return swatch
      }),
    )
    ramp.setAttribute('aria-hidden', 'true')
    const [first, last] = ends()
    const rapids = make('span', { className: 'dashes' })
    rapids.setAttribute('aria-hidden', 'true')
    legend.replaceChildren(make('span', {}, `${title}:`), make('span', {}, first), ramp, make('span', {}, last), rapids, make('span', {}, say.path.rapid))
  }

  /** @param {Column} column */
  function fillPlaces(column) {
    if (!run) {
      marks.replaceChildren()
      return list.replaceChildren(make('p', { className: 'empty' }, say.common.computing))
    }
    const { places, seconds: all, elsewhere_s: elsewhere } = run.summary.lost
    marks.replaceChildren(
      ...places.map(({ distance_mm: [from, to] }, index) => {
        const mark = make('span', {}, String(index + 1))
        mark.dataset.at = String(0.5 * (from + to))
        return mark
      }),
    )
    const cells = (/** @type {number} */ lostHere) => [
      make('td', {}, `${number(lostHere)} s`),
      make('td', {}, all > 0 ? percent(lostHere / all).replace('+', '') : '–'),
    ]
    const rows = places.map((place, index) => {
      const [from, to] = place.lines
      const go = make('button', { type: 'button', title: say.path.showEverywhere }, from === to ? `${from}` : `${from}–${to}`)
      go.setAttribute('aria-label', say.path.showPlace(index + 1, go.textContent))
      go.addEventListener('click', () => choosePlace(place))
      return make('tr', {}, make('th', { scope: 'row' }, String(index + 1)), make('td', {}, go), make('td', {}, worded(place.text)), ...cells(place.seconds))
    })
    const rest = make('tr', {}, make('th', { scope: 'row', colSpan: 3 }, say.path.everywhereElse), ...cells(elsewhere))
    const total = make('tr', {}, make('th', { scope: 'row', colSpan: 3 }, say.path.total), ...cells(all))
    const titles = ['', say.common.lines, say.path.why, say.common.lost, say.path.ofAll].map((title) => make('th', { scope: 'col' }, title))
    titles[0].append(make('span', { className: 'away' }, say.path.place))
    const which = column === null ? columnLabel(column) : say.path.atTolerance(columnLabel(column))
    const caption = make('caption', {}, places.length > 0 ? say.path.costliest(which) : say.path.nothingLost(which))
    const scroll = make('div', { className: 'scroll', tabIndex: 0 }, make('table', {}, caption, make('thead', {}, make('tr', {}, ...titles)), make('tbody', {}, ...rows), make('tfoot', {}, rest, total)))
    scroll.setAttribute('role', 'group')
    scroll.setAttribute('aria-label', say.path.costliestLabel)
    list.replaceChildren(scroll)
    setPlace(places.find((place) => place === chosenPlace))
  }

  return {
    /** Marks a stretch of the path, mm. @param {[number, number]} stretch */
    keep(stretch) {
      fill()
      if (outcome) keep(stretch)
    },
    /** @param {State} state */
    update(state) {
      program = state.programs.find(({ id }) => id === state.selected)
      outcome = program?.outcome
      root.classList.toggle('stale', Boolean(outcome) && outcome?.motion !== state.machine.motion)
      const recording = recordingOf(state)
      lost = recording?.program === program?.id && recording?.match?.report ? recording?.match.columns : undefined
      options(by, COLORS.filter(([value]) => value !== 'lost' || lost).map(([value, title]) => [value, title]))
      columns = columnsOf(state, outcome)
      options(at, columns.map((column) => [columnLabel(column), columnLabel(column)]))
      if (!outcome) {
        canvas.width = canvas.width // empties it
        marks.replaceChildren()
        legend.replaceChildren()
        list.replaceChildren()
        filled = []
      }
      refill()
    },
  }
}

/** A round length. @param {number} length  mm */
const lengthLabel = (length) => `${figures(length)} mm`

/** Gives a choice its options and keeps what is chosen. @param {HTMLSelectElement} select @param {string[][]} all  value and title */
function options(select, all) {
  const before = select.value
  const isSame = all.length === select.options.length && all.every(([value], index) => select.options[index].value === value)
  if (isSame) return
  select.replaceChildren(...all.map(([value, title]) => make('option', { value }, title)))
  if (all.some(([value]) => value === before)) select.value = before
}
