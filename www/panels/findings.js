// What is said about a recording beyond where time was lost: a sentence first, then the causes and the regions it
// stands on. It is hidden while nothing is said.

import { lostLabel } from '../pkg/truefeed.js'
import { find, make } from '../dom.js'
import { recordingOf } from '../recordings.js'

/** @import { Findings, Place, State } from "../types.js" */

/** @param {HTMLElement} root @param {{show(place: Pick<Place, 'distance_mm'>): void}} actions */
export function mount(root, actions) {
  const place = find(root, '.result')
  /** @type {Findings | null} */
  let shown = null

  /** @param {Findings} findings */
  function fill({ sentence, causes, regions }) {
    const items = causes.map(({ label, detail, lines, seconds, confidence }) => {
      const facts = [
        detail,
        lines.length > 0 ? `lines ${lines.map(range).join(', ')}` : '',
        seconds === null ? '' : lostLabel(seconds),
        confidence === null ? '' : `${Math.round(100 * confidence)} % sure`,
      ]
      return make('li', {}, make('b', {}, label), ` ${facts.filter(Boolean).join(' · ')}`)
    })
    const places = regions.map((region) => {
      const go = make('button', { type: 'button', title: 'Show it in the charts' }, `lines ${range(region.lines)}`)
      go.addEventListener('click', () => actions.show(region))
      return make('li', {}, go, ` ${lostLabel(region.seconds)}`)
    })
    place.replaceChildren(
      make('p', { className: 'sentence' }, sentence),
      make('ol', { className: 'causes' }, ...items),
      make('ul', { className: 'regions' }, ...places),
    )
  }

  return {
    /** @param {State} state */
    update(state) {
      const findings = recordingOf(state)?.findings ?? null
      if (findings === shown) return
      shown = findings
      root.hidden = !findings
      if (findings) fill(findings)
    },
  }
}

/** @param {[number, number]} lines */
const range = ([from, to]) => (from === to ? `${from}` : `${from}–${to}`)
