// Finds the browser of the tests. Run as a program it prints the path, or fails if there is none.

import { accessSync, constants } from 'node:fs'
import { delimiter, join } from 'node:path'
import { argv, env } from 'node:process'
import { fileURLToPath } from 'node:url'

const NAMES = ['chromium', 'chromium-browser', 'google-chrome', 'google-chrome-stable']

/**
 * Path of Chromium or Chrome: $CHROMIUM if set, else the first known name on the search path.
 * @returns {string | undefined}
 */
export function findChromium() {
  if (env.CHROMIUM) return env.CHROMIUM
  const folders = [...(env.PATH ?? '').split(delimiter), '/usr/bin']
  return NAMES.flatMap((name) => folders.map((folder) => join(folder, name))).find(isExecutable)
}

/** @param {string} path */
function isExecutable(path) {
  try {
    accessSync(path, constants.X_OK)
    return true
  } catch {
    return false
  }
}

if (argv[1] === fileURLToPath(import.meta.url)) {
  const path = findChromium()
  if (path) console.log(path)
  else process.exitCode = 1
}
