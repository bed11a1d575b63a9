// Charts as files: SVG as Rust draws it, and PNG made from it.

import { make } from './dom.js'
import { say } from './texts.js'

/**
 * Two buttons that save a chart.
 * @param {HTMLElement} toolbar
 * @param {string} name  of the file
 * @param {string} title  of the chart, for those who do not see it
 * @param {() => string | undefined | Promise<string | undefined>} svg
 */
export function offerPictures(toolbar, name, title, svg) {
  for (const kind of /** @type {const} */ (['SVG', 'PNG'])) {
    const element = make('button', { type: 'button', className: 'picture', title: say.pictures.saveAs(kind) }, kind)
    element.setAttribute('aria-label', say.pictures.saveTitleAs(title, kind))
    element.addEventListener('click', async () => {
      const text = await svg()
      if (text) (await import('./save.js')).savePicture(kind, text, name)
    })
    toolbar.append(element)
  }
}
