// Gives files to the user.

import { make } from './dom.js'
import { whole } from './whole.js'

/** @import { Values } from "./types.js" */

/** @param {Values} values */
export async function saveMachine(values) {
  const { machineFile } = await whole()
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
