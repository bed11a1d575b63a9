// Archives that are dropped: unpacked by Rust.

import { inside } from './dropped.js'
import { whole } from '../whole.js'

/** The files of an archive that was dropped; none, with the reason told, where it cannot be unpacked. @param {File} archive @param {(message: string) => unknown} refuse */
export async function unpacked(archive, refuse) {
  const { Archived } = await whole()
  try {
    const files = new Archived(new Uint8Array(await archive.arrayBuffer()))
    const found = inside(archive.name, files)
    files.free()
    return found
  } catch (reason) {
    if (typeof reason !== 'string') throw reason
    refuse(`${archive.name}: ${reason}`)
    return []
  }
}
