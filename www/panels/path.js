// The path in space beside its program text, and the places that cost most; all linked with the charts.

import { PathView } from '../pkg/truefeed_whole.js'
import { mountTolerance } from '../at_tolerance.js'
import { columnsOf, machineOf, quotedColumn } from '../columns.js'
import { find, make, offer } from '../dom.js'
import { sheetOf } from '../drawing.js'
import { feedrate, lengthLabel, lengthWord, roundLength } from '../format.js'
import { mountListing } from '../listing.js'
import { namedIn, operationAt, operationTitle, toolTitle } from '../operations.js'
import { offerPictures } from '../pictures.js'
import { link } from '../plot.js'
import { recordingOf } from '../recordings.js'
import { offerShortcuts } from '../shortcuts.js'
import { say } from '../texts_later.js'
import { lineOf } from './chart.js'
import { axesOf } from './path_axes.js'
import { choices, color, endsOf, fillLegend, wayOf } from './path_colors.js'
import { mountPlaces } from './path_places.js'
import { pathByPointer } from './path_pointer.js'
import { mountPlayer } from './player.js'

/** @import { Fed } from "../cutting/job.js" */
/** @import { LostAt, MatchedColumns, Outcome, Program, Revised, Run, State } from "../types.js" */

const ZOOM = 1.5
const STEP_PX = 60
const STEP_RAD = 0.12
const WALK_PX = 6
const GAP_PX = 8
const MOST_PIXELS = 3e6
const NONE_FED = /** @type {Fed[]} */ ([])

/**
 * @param {HTMLElement} root
 * @param {{reveal(stretch: [number, number]): void}} actions
 */
export function mount(root, actions) {
  const space = find(root, '.space')
  const canvas = /** @type {HTMLCanvasElement} */ (find(root, 'canvas'))
  const by = /** @type {HTMLSelectElement} */ (find(root, '.by'))
  const [marks, axes, scale, here, reading, legend, list] = ['.marks', '.axes', '.scale', '.here', '.reading', '.legend', '.places'].map((selector) => find(root, selector))
  const looks = /** @type {NodeListOf<HTMLElement>} */ (root.querySelectorAll('[data-look]'))
  const dark = window.matchMedia('(prefers-color-scheme: dark)')
  const view = new PathView()
  const places = mountPlaces(list, marks, choosePlace)
  const player = mountPlayer(find(root, '.player'), {
    at(distance) {
      view.runTo(distance)
      showAt(distance, false)
      listing.choose(view.lineAt(distance) ?? 0)
      others.point(distance)
      here.classList.add('playing')
      moved()
    },
    ended: rest,
  })
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

  offerShortcuts(find(root, '.tools'), find(root, '.halves'), say.path.keys)
  offerPictures(find(root, '.tools'), 'path', say.path.picture, () => {
    const [length] = view.scale()
    return outcome ? view.svg(...endsOf(view), roundLength(length)) : undefined
  })

  /** @type {Program | undefined} */
  let program
  /** @type {Outcome | null | undefined} */
  let outcome
  /** @type {Run | undefined} */
  let run
  /** @type {MatchedColumns | undefined} */
  let lost
  /** @type {Revised | null} */
  let revised = null
  /** How teeth are fed, where forces were computed. @type {Fed[]} */
  let fed = NONE_FED
  /** What the picture shows now, so that it is made anew only when something else is to be shown. @type {unknown[]} */
  let filled = []
  /** @type {string | undefined} */
  let fitted
  /** @type {Program | undefined} */
  let listed
  let look = 'top'
  let readAt = NaN

  // Drawing

  const sheet = sheetOf(
    canvas,
    () => {
      fill()
      if (!outcome) return
      const { width, height } = sheet
      // While it moves the page's own pixels do: it has no letters.
      view.draw(canvas, width, height, Math.min(sheet.ratio(1), Math.sqrt(MOST_PIXELS / (width * height))))
      overlay(height)
    },
    root,
  )
  const { redraw, moved } = sheet

  /** Places what lies over the picture. @param {number} height */
  function overlay(height) {
    for (const mark of /** @type {Iterable<HTMLElement>} */ (marks.children)) put(mark, Number(mark.dataset.at))
    if (!here.hidden) put(here, readAt)
    axes.replaceChildren(...axesOf(view, height))
    const [length, width] = view.scale()
    scale.style.width = `${width}px`
    scale.textContent = roundLength(length)
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
    const operation = operations().length > 1 ? operationAt(operations(), distance) : undefined
    const tool = operation ? [make('p', { className: 'small' }, `${toolTitle(operation)} · ${operationTitle(operation)}`)] : []
    reading.replaceChildren(make('p', {}, make('strong', {}, lengthLabel(distance)), fast), ...tool, ...lineOf(view.lineAt(distance), program))
    // In the corner that is away from what is read.
    const [x] = view.locate(distance)
    const toTheLeft = x > sheet.width / 2
    Object.assign(reading.style, { left: toTheLeft ? `${GAP_PX}px` : 'auto', right: toTheLeft ? 'auto' : `${GAP_PX}px`, top: `${GAP_PX}px` })
  }

  function hide() {
    readAt = NaN
    here.hidden = true
    reading.hidden = true
    listing.point(0)
  }

  /** Shows all of the path again, where it was shown as far as it had been run. */
  function rest() {
    view.runTo(undefined)
    here.classList.remove('playing')
    redraw()
  }

  function leave() {
    if (player.isPlaying()) return
    hide()
    others.hide()
  }

  /** @param {number} distance */
  function read(distance) {
    if (player.isPlaying()) return
    showAt(distance, true)
    listing.point(view.lineAt(distance) ?? 0)
    others.point(distance)
  }

  /** Marks a stretch of the path. @param {[number, number]} stretch */
  function keep([from, to]) {
    view.mark(from, to)
    view.reveal(0.5 * (from + to))
    places.choose(undefined)
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
    player.from(distance)
    others.choose(distance)
  }

  /** @param {LostAt} place */
  function choosePlace(place) {
    const [from, to] = place.distance_mm
    keep([from, to])
    places.choose(place)
    listing.choose(place.lines[0])
    actions.reveal([from, to])
    const middle = 0.5 * (from + to)
    showAt(middle, false)
    others.point(middle)
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
  by.addEventListener('change', refill)
  const at = mountTolerance(/** @type {HTMLSelectElement} */ (find(root, '.at')), refill)

  space.addEventListener('keydown', (event) => {
    if (!outcome || event.ctrlKey || event.metaKey || event.altKey) return
    if (event.shiftKey && event.key.startsWith('Arrow')) {
      event.preventDefault()
      return walk(event.key === 'ArrowLeft' || event.key === 'ArrowDown' ? -1 : 1)
    }
    if (event.key === ' ') {
      event.preventDefault()
      return player.toggle()
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

  space.addEventListener('dblclick', () => lookFrom(look))
  space.addEventListener('blur', leave)
  pathByPointer(space, view, { isShown: () => Boolean(outcome), turns: () => look === 'turned', read, leave, moved, chosen: choose })
  dark.addEventListener('change', () => {
    filled = []
    refill()
  })

  // Filling

  /** What is run in order. */
  const operations = () => namedIn(program, run?.summary.operations ?? [])

  /** Shows what is to be shown now, where it is in sight. */
  function refill() {
    if (sheet.isInSight) fill()
    redraw()
  }

  function fill() {
    if (!outcome) return
    const column = at.column() ?? null
    run = outcome.runs.get(column)
    const now = [outcome, run, lost, revised, fed, by.value, lengthWord()]
    if (now.length === filled.length && now.every((value, index) => value === filled[index])) return
    const isOther = filled[0] !== outcome
    filled = now
    if (isOther) {
      const { end, feedrate: feed, rapid, line } = outcome.steps
      view.program(outcome.trail.points, outcome.trail.distance, end, feed, rapid, line)
      rest()
      hide()
    }
    view.setDark(dark.matches)
    if (run) view.pace(run.columns.paceEnd, run.columns.paceFeedrate)
    const ways = choices(operations(), Boolean(lost), Boolean(revised), fed.length > 0)
    offer(by, ways, ways.some(([value]) => value === by.value) ? by.value : ways[0][0])
    if (by.value === 'revised' && revised) view.lost(revised.columns.distance, revised.columns.later)
    else if (lost) view.lost(lost.lostDistance, lost.lostSeconds)
    color(view, by.value, operations(), fed)
    player.fill(run?.columns)
    if (listed !== program && program) listing.fill(program.lines)
    listed = program
    const path = `${program?.id} ${outcome.steps.end.at(-1)}`
    if (fitted !== path) lookFrom(view.isDeep() ? 'turned' : 'top')
    fitted = path
    fillLegend(legend, view, by.value, operations(), revised?.name, fed)
    places.fill(run, column)
    canvas.setAttribute('aria-label', say.path.described(program?.name, wayOf(by.value)))
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
      root.classList.toggle('stale', Boolean(outcome) && outcome?.motion !== machineOf(state).motion)
      const recording = recordingOf(state)
      lost = recording?.program === program?.id && recording?.match?.report ? recording?.match.columns : undefined
      revised = state.revised?.program === program?.id ? state.revised : null
      fed = (state.cut?.program === program?.id && state.cut?.fed) || NONE_FED
      at.update(columnsOf(state, program), quotedColumn(state, program))
      if (!outcome) {
        canvas.getContext('2d')?.clearRect(0, 0, canvas.width, canvas.height)
        legend.replaceChildren()
        places.empty()
        player.fill(undefined)
        filled = []
      }
      refill()
    },
  }
}
