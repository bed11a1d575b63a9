// Gives a machine to the user as a file.

import { machineFile } from './pkg/truefeed.js'
import { make } from './dom.js'

/** @import { Values } from "./types.js" */

/** @param {Values} values */
export function saveMachine(values) {
  const file = new Blob([machineFile(JSON.stringify(values)) ?? ''], { type: 'application/toml' })
  const link = make('a', { href: URL.createObjectURL(file), download: 'machine.toml' })
  link.click()
  URL.revokeObjectURL(link.href)
}
