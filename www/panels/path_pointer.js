// What pointers do with the path: they read it, turn it, move it, and pinch it.

import { CLICK_PX, pixelOf } from '../plot_pointer.js'
import { zoomByWheel } from '../wheel.js'

/** @import { PathView } from "../pkg/truefeed_whole.js" */

const RAD_PER_PX = 0.008

/**
 * @param {HTMLElement} space
 * @param {PathView} view
 * @param {object} hear
 * @param {() => boolean} hear.isShown
 * @param {() => boolean} hear.turns  whether dragging turns the path
 * @param {(distance: number) => void} hear.read  the pointer is on the path, mm
 * @param {() => void} hear.leave
 * @param {() => void} hear.moved
 * @param {(distance: number) => void} hear.chosen  the path was clicked on, mm
 */
export function pathByPointer(space, view, { isShown, turns, read, leave, moved, chosen }) {
  const pixel = (/** @type {MouseEvent} */ event) => pixelOf(space, event)
  zoomByWheel(space, isShown, (factor, event) => {
    const { x, y } = pixel(event)
    view.zoom(factor, x, y)
    moved()
  })
  space.addEventListener('pointerleave', (event) => event.pointerType !== 'touch' && leave())
  space.addEventListener('contextmenu', (event) => event.preventDefault())

  /** Where each finger or button is, and whether it has moved. @type {Map<number, {x: number, y: number, begun: {x: number, y: number}}>} */
  const pointers = new Map()
  let hasDragged = false

  space.addEventListener('pointerdown', (event) => {
    if (!isShown()) return
    const now = pixel(event)
    if (pointers.size === 0) hasDragged = false
    pointers.set(event.pointerId, { ...now, begun: now })
    space.setPointerCapture(event.pointerId)
  })
  space.addEventListener('pointermove', (event) => {
    if (!isShown()) return
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
    } else if (turns() && !event.shiftKey && (event.buttons & 1) === 1) {
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
      if (distance !== undefined) chosen(distance)
    })
  }
}
