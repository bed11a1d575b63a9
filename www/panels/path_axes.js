// Where X, Y and Z point in a picture of the path.

import { make } from '../dom.js'

/** @import { PathView } from "../pkg/truefeed_whole.js" */

const AXIS_PX = 26
/** Shorter axes point at the one who looks. */
const LEAST_PX = 6

/** A shaft and a letter for each axis, in the lower left corner. @param {PathView} view @param {number} height  of the picture, pixels */
export function axesOf(view, height) {
  const directions = view.axes()
  const [left, bottom] = [AXIS_PX + 14, height - AXIS_PX - 14]
  return ['X', 'Y', 'Z'].flatMap((name, index) => {
    const [x, y] = directions.subarray(2 * index, 2 * index + 2)
    const size = Math.hypot(x, y) * AXIS_PX
    if (size < LEAST_PX) return []
    const shaft = make('i', {})
    Object.assign(shaft.style, { left: `${left}px`, top: `${bottom}px`, width: `${size}px`, transform: `rotate(${Math.atan2(y, x)}rad)` })
    const label = make('span', {}, name)
    const far = AXIS_PX * (1 + 10 / size)
    Object.assign(label.style, { left: `${left + x * far}px`, top: `${bottom + y * far}px` })
    return [shaft, label]
  })
}
