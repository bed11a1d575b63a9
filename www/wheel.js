// The wheel scrolls the page. With Ctrl or ⌘, as a pinch on a trackpad comes too, it zooms a picture; the first turn without says so.

import { make } from './dom.js'
import { say } from './texts.js'

/** A notch of a wheel is far more than a step of a pinch. */
const MOST_PX = 24
const PER_PX = 0.011
/** Pixels of a line, for browsers that count in lines. */
const LINE_PX = 16
const HINT_MS = 2200

let wasHinted = false

/**
 * @param {HTMLElement} element
 * @param {() => boolean} isShown  whether there is something to zoom
 * @param {(factor: number, event: WheelEvent) => void} zoom
 */
export function zoomByWheel(element, isShown, zoom) {
  element.addEventListener(
    'wheel',
    (event) => {
      if (!isShown()) return
      if (!event.ctrlKey && !event.metaKey) return hint(element)
      event.preventDefault()
      wasHinted = true
      const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? LINE_PX : 1)
      zoom(Math.exp(-PER_PX * Math.min(Math.max(pixels, -MOST_PX), MOST_PX)), event)
    },
    { passive: false },
  )
}

/** @param {HTMLElement} element */
function hint(element) {
  if (wasHinted) return
  wasHinted = true
  const told = make('p', { className: 'wheel-hint' }, say.charts.wheelHint(/Mac|iP/.test(navigator.platform)))
  told.setAttribute('role', 'status')
  element.append(told)
  setTimeout(() => told.remove(), HINT_MS)
}
