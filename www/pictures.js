// Charts as files: SVG as Rust draws it, and PNG made from it.

import { make } from './dom.js'
import { saveBlob } from './save.js'
import { say } from './texts.js'

/** Pixels of a PNG for one of the SVG. */
const RATIO = 2

/**
 * Two buttons that save a chart.
 * @param {HTMLElement} toolbar
 * @param {string} name  of the file
 * @param {string} title  of the chart, for those who do not see it
 * @param {() => string | undefined | Promise<string | undefined>} svg
 */
export function offerPictures(toolbar, name, title, svg) {
  const button = (/** @type {string} */ kind, /** @type {(text: string) => void} */ save) => {
    const element = make('button', { type: 'button', className: 'picture', title: say.pictures.saveAs(kind) }, kind)
    element.setAttribute('aria-label', say.pictures.saveTitleAs(title, kind))
    element.addEventListener('click', async () => {
      const text = await svg()
      if (text) save(text)
    })
    return element
  }
  toolbar.append(
    button('SVG', (text) => saveBlob(new Blob([text], { type: 'image/svg+xml' }), `${name}.svg`)),
    button('PNG', async (text) => saveBlob(await pngOf(text), `${name}.png`)),
  )
}

/** @param {string} svg @returns {Promise<Blob>} */
async function pngOf(svg) {
  const image = make('img', { src: addressOf(svg) })
  await image.decode()
  const canvas = make('canvas', { width: RATIO * image.naturalWidth, height: RATIO * image.naturalHeight })
  canvas.getContext('2d')?.drawImage(image, 0, 0, canvas.width, canvas.height)
  return new Promise((resolve, reject) =>
    canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error('the chart gives no PNG'))), 'image/png'),
  )
}

/** A picture as an address that the policy of the page allows. @param {string} svg */
export const addressOf = (svg) => `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`
