// Gives files to the user.

import { machineFile } from './pkg/truefeed.js'
import { make } from './dom.js'

/** @import { Values } from "./types.js" */

/** @param {Values} values */
export function saveMachine(values) {
  saveFile(machineFile(JSON.stringify(values)) ?? '', 'application/toml', 'machine.toml')
}

/** @param {string} text @param {string} type @param {string} name */
export function saveFile(text, type, name) {
  saveBlob(new Blob([text], { type }), name)
}

/** @param {Blob} blob @param {string} name */
export function saveBlob(blob, name) {
  const link = make('a', { href: URL.createObjectURL(blob), download: name })
  link.click()
  URL.revokeObjectURL(link.href)
}
