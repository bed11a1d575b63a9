// Finds the browser of the tests. Run as a program it prints the path, or fails if there is none.

import { findExecutable, printIfRun } from './executable.mjs'

const NAMES = ['chromium', 'chromium-browser', 'google-chrome', 'google-chrome-stable']

/** Path of Chromium or Chrome: $CHROMIUM if set, else the first known name on the search path. */
export const findChromium = () => findExecutable('CHROMIUM', NAMES)

printIfRun(import.meta.url, findChromium)
