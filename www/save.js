// Gives files to the user. Fetched when the first is asked for.

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

/** Pixels of a PNG for one of the SVG. */
const RATIO = 2

/** @param {"SVG" | "PNG"} kind @param {string} svg @param {string} name  of the file, without what tells its kind */
export async function savePicture(kind, svg, name) {
  saveBlob(kind === 'SVG' ? new Blob([svg], { type: 'image/svg+xml' }) : await pngOf(svg), `${name}.${kind.toLowerCase()}`)
}

/** @param {string} svg @returns {Promise<Blob>} */
async function pngOf(svg) {
  const image = make('img', { src: addressOf(svg) })
  await image.decode()
  const canvas = make('canvas', { width: RATIO * image.naturalWidth, height: RATIO * image.naturalHeight })
  canvas.getContext('2d')?.drawImage(image, 0, 0, canvas.width, canvas.height)
  return new Promise((resolve, reject) => canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error('the chart gives no PNG'))), 'image/png'))
}

/** A picture as an address that the policy of the page allows. @param {string} svg */
export const addressOf = (svg) => `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`

/** How long a browser may take to read what it saves: Firefox and Safari only begin to when the click has returned. */
const READING_MS = 60_000

/** @param {Blob} blob @param {string} name */
function saveBlob(blob, name) {
  const link = make('a', { href: URL.createObjectURL(blob), download: name })
  link.click()
  setTimeout(() => URL.revokeObjectURL(link.href), READING_MS)
}
