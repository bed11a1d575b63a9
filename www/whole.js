// The whole module on the page, beside the one of the first visit: fetched when it is first asked for, by what can wait.

import { wholeModule } from './module.js'
import { axis, lengthWord } from './format.js'

/** @typedef {typeof import("./pkg/truefeed_whole.js")} Whole */

/** @type {Promise<Whole> | undefined} */
let asked

/** Its functions and classes, ready. @returns {Promise<Whole>} */
export function whole() {
  asked ??= load().catch((error) => {
    // The next one tries again.
    asked = undefined
    throw error
  })
  return asked
}

async function load() {
  const [script, { module }] = await Promise.all([import('./pkg/truefeed_whole.js'), wholeModule()])
  await script.default({ module_or_path: module })
  script.setNumbers(axis)
  script.setLengthUnit(lengthWord)
  return script
}
