// The machine as measured: of each law a small chart and what it says at its ends, and why others are missing.

import { LawPicture } from '../pkg/truefeed_whole.js'
import { make } from '../dom.js'
import { sheetOf } from '../drawing.js'
import { worded } from '../format.js'
import { say } from '../texts_later.js'

/** @import { Law, Measured } from "../types.js" */

/** A section that shows the laws, closed until it is opened; nothing of a report that has none. @param {Measured | null | undefined} measured @returns {HTMLElement[]} */
export function measuredLaws(measured) {
  if (!measured) return []
  const place = make('div', { className: 'laws' })
  const absent = measured.absent.map(({ title, reason }) => make('p', { className: 'facts' }, worded(say.measured.absent(title, reason))))
  const all = make('details', { className: 'measured' }, make('summary', {}, make('h3', {}, say.measured.title)), make('p', { className: 'facts' }, say.measured.legend), place, ...absent)
  // A chart costs a canvas: none before it is asked for.
  all.addEventListener('toggle', () => all.open && !place.hasChildNodes() && place.append(...measured.laws.map(figureOf)))
  return [all]
}

/** @param {Law} law */
function figureOf(law) {
  const picture = new LawPicture(JSON.stringify(law))
  const canvas = make('canvas', { role: 'img' })
  canvas.setAttribute('aria-label', worded(`${law.title}: ${law.told}`))
  const dark = window.matchMedia('(prefers-color-scheme: dark)')
  const sheet = sheetOf(canvas, () => picture.draw(canvas, sheet.width, sheet.height, sheet.ratio(), dark.matches))
  dark.addEventListener('change', () => sheet.redraw())
  const caption = make('figcaption', {}, make('strong', {}, worded(law.title)), ` ${worded(law.told)}`)
  return make('figure', { className: 'law' }, canvas, caption)
}
