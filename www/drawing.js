// When pictures are drawn, how large and how fine they are, so that no frame takes long and none asks the browser to lay out the page.

/** So much drawing goes in one frame, ms; what is left of it is the browser's own. */
const ROOM_MS = 6
/** A picture rests when it has not moved for so long. */
const REST_MS = 160
/** plotters draws on whole pixels; twice as many as the page's make slanting lines smooth on any screen. */
const LEAST_RATIO = 2

/** @type {Set<() => void>} */
const waiting = new Set()
let isAsked = false
/** @type {((value?: unknown) => void)[]} */
let heard = []

/** Draws in the next frame that has room for it, once however often it is asked for until then. @param {() => void} draw */
function inFrame(draw) {
  waiting.add(draw)
  askFrame()
}

function askFrame() {
  if (!isAsked) requestAnimationFrame(next)
  isAsked = true
}

/** When all is drawn that waits to be. */
export const drawn = () => new Promise((done) => (waiting.size > 0 ? heard.push(done) : done(undefined)))

/** What can wait until no picture moves. @type {Set<() => void>} */
const patient = new Set()
/** @type {Set<Sheet>} */
const moving = new Set()

/** Does what takes its time, such as filling a table, when no picture moves; once however often it is asked for until then. @param {() => void} what */
export function whenStill(what) {
  patient.add(what)
  calm()
}

function calm() {
  if (moving.size > 0) return
  for (const what of patient) inFrame(what)
  patient.clear()
}

/** @param {number} begun */
function next(begun) {
  isAsked = false
  // One at least, so that every picture has its turn.
  for (const draw of [...waiting]) {
    waiting.delete(draw)
    draw()
    if (performance.now() - begun > ROOM_MS) break
  }
  if (waiting.size > 0) return askFrame()
  for (const done of heard) done()
  heard = []
}

/**
 * Where a picture is drawn: its size, whether it is in sight, and how finely.
 * @typedef {object} Sheet
 * @property {number} width  pixels of the page
 * @property {number} height
 * @property {boolean} isInSight  or nearly
 * @property {(coarse?: number) => number} ratio  pixels of the picture for one of the page; others while it moves
 * @property {() => void} redraw  draws when there is room, if it is in sight
 * @property {() => void} moved  draws what moves, and finely when it rests
 */

/** Watches the place of a picture, and whether what it belongs to is in sight. @param {HTMLElement} element @param {() => void} draw @param {HTMLElement} whole @returns {Sheet} */
export function sheetOf(element, draw, whole = element) {
  let rest = 0
  const drawInSight = () => {
    if (sheet.isInSight && sheet.width > 0 && sheet.height > 0) draw()
  }
  /** @type {Sheet} */
  const sheet = {
    width: 0,
    height: 0,
    isInSight: false,
    ratio: (coarse = window.devicePixelRatio) => (moving.has(sheet) ? coarse : Math.max(window.devicePixelRatio, LEAST_RATIO)),
    redraw: () => inFrame(drawInSight),
    moved() {
      moving.add(sheet)
      clearTimeout(rest)
      rest = window.setTimeout(() => {
        moving.delete(sheet)
        sheet.redraw()
        calm()
      }, REST_MS)
      sheet.redraw()
    },
  }
  new ResizeObserver(([{ contentRect }]) => {
    sheet.width = Math.round(contentRect.width)
    sheet.height = Math.round(contentRect.height)
    sheet.redraw()
  }).observe(element)
  new IntersectionObserver(
    (entries) => {
      sheet.isInSight = entries.at(-1)?.isIntersecting ?? false
      if (sheet.isInSight) sheet.redraw()
    },
    { rootMargin: '300px' },
  ).observe(whole)
  return sheet
}
