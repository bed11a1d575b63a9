// Finds a browser that is installed, by a variable or on the search path.

import { accessSync, constants } from 'node:fs'
import { delimiter, join } from 'node:path'
import { argv, env } from 'node:process'
import { fileURLToPath } from 'node:url'

/**
 * Path of a program: that of the variable if set, else the first known name on the search path.
 * @param {string} variable
 * @param {string[]} names
 * @returns {string | undefined}
 */
export function findExecutable(variable, names) {
  if (env[variable]) return env[variable]
  const folders = [...(env.PATH ?? '').split(delimiter), '/usr/bin']
  return names.flatMap((name) => folders.map((folder) => join(folder, name))).find(isExecutable)
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

/**
 * Prints the path where the module of this address is run as a program, or fails if there is none.
 * @param {string} url
 * @param {() => string | undefined} find
 */
export function printIfRun(url, find) {
  if (argv[1] !== fileURLToPath(url)) return
  const path = find()
  if (path) console.log(path)
  else process.exitCode = 1
}
