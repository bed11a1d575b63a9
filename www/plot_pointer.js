// What pointers do with a chart: they read it, drag a box to zoom to, move it, and pinch it.

import { find } from './dom.js'

/** @import { Chart } from "./plot.js" */

/** Less is a click. */
export const CLICK_PX = 4

/** Where an event is in an element, pixels. @param {HTMLElement} element @param {MouseEvent} event */
export function pixelOf(element, event) {
  const { left, top } = element.getBoundingClientRect()
  return { x: event.clientX - left - element.clientLeft, y: event.clientY - top - element.clientTop }
}

/**
 * @param {HTMLElement} plot
 * @param {Chart} chart
 * @param {object} hear
 * @param {() => boolean} hear.isShown
 * @param {(x: number) => void} hear.read  the pointer is on a pixel column
 * @param {() => void} hear.leave
 * @param {() => void} hear.moved  something else is in sight
 * @param {(x: number) => void} hear.chosen  a pixel column was clicked on
 */
export function byPointer(plot, chart, { isShown, read, leave, moved, chosen }) {
  const box = find(plot, '.box')
  const pixel = (/** @type {MouseEvent} */ event) => pixelOf(plot, event)
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
  for (const end of ['pointerup', 'pointercancel']) plot.addEventListener(end, (event) => fingers.delete(/** @type {PointerEvent} */ (event).pointerId))

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
      if (isClick && !start.shiftKey && left <= from.x && from.x <= right) chosen(from.x)
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
}
