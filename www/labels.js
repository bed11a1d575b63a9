// Numbers with their units as Rust words them, written as the browser's language does.

import * as rust from './pkg/truefeed.js'
import { worded } from './format.js'

/** A contour tolerance. @param {number} tolerance  mm */
export const toleranceLabel = (tolerance) => worded(rust.toleranceLabel(tolerance))

/** A contour error. @param {number} deviation  mm */
export const deviationLabel = (deviation) => worded(rust.deviationLabel(deviation))

/** A signed time. @param {number} seconds */
export const lostLabel = (seconds) => worded(rust.lostLabel(seconds))
