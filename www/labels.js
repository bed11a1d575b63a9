// Numbers with their units as Rust words them, written as the browser's language does.

import * as rust from './pkg/truefeed.js'
import { lengthWord, number, worded } from './format.js'

/** A contour tolerance in the unit shown. @param {number} tolerance  mm */
export const toleranceLabel = (tolerance) => worded(rust.toleranceShown(tolerance))

/** A contour tolerance in µm, for documents and as the key of a column; it does not depend on the unit shown. @param {number} tolerance  mm */
export const toleranceKey = (tolerance) => worded(rust.toleranceLabel(tolerance))

/** A contour error. @param {number} deviation  mm */
export const deviationLabel = (deviation) => worded(rust.deviationLabel(deviation))

/** An error in about three figures. @param {number} error  mm */
export const errorLabel = (error) => (lengthWord() === 'metric' ? `${number(1000 * error)} µm` : deviationLabel(error))

/** A signed time. @param {number} seconds */
export const lostLabel = (seconds) => worded(rust.lostLabel(seconds))
