// Everything the program's readers had to say, with the line it is about.

import { find, make } from '../dom.js'
import { count } from '../format.js'
import { say } from '../texts.js'

/** @import { Diagnostic, Program, State } from "../types.js" */

const SHOWN = 100
/** @type {Record<Diagnostic["severity"], import('../texts.js').Sentence>} */
const NAMES = { error: say.diagnostics.error, warning: say.diagnostics.warning, info: say.diagnostics.note }

/** @param {HTMLElement} root @param {HTMLElement} strip  with the button that opens it */
export function mount(root, strip) {
  const list = find(root, '.list')
  const counts = find(root, '.counts')
  /** @type {Diagnostic[] | null} */
  let shown = null

  /** @param {Program} program @param {Diagnostic[]} diagnostics @param {number} most */
  function fill(program, diagnostics, most) {
    const rows = diagnostics.slice(0, most).map(({ line, severity, message }) => {
      const code = make('code', {})
      program.lines.at(line).then((text) => (code.textContent = text))
      return make('tr', { className: severity }, make('td', { className: 'line' }, String(line)), make('td', { className: 'severity' }, NAMES[severity](1)), make('td', {}, message, code))
    })
    const titles = [say.common.line, say.diagnostics.kind, say.diagnostics.what].map((title) => make('th', { scope: 'col' }, title))
    list.replaceChildren(make('table', {}, make('thead', {}, make('tr', {}, ...titles)), make('tbody', {}, ...rows)))
    if (most < diagnostics.length) {
      const more = make('button', { type: 'button' }, say.diagnostics.showAll(count(diagnostics.length)))
      more.addEventListener('click', () => fill(program, diagnostics, Infinity))
      list.append(more)
    }
  }

  return {
    /** @param {State} state */
    update(state) {
      const program = state.programs.find(({ id }) => id === state.selected)
      const diagnostics = program?.outcome?.summary.diagnostics ?? null
      if (diagnostics === shown) return
      shown = diagnostics
      root.hidden = !diagnostics?.length
      find(strip, '.counts').textContent = diagnostics ? count(diagnostics.length) : ''
      if (!program || !diagnostics) return
      const parts = Object.entries(NAMES).flatMap(([severity, named]) => {
        const number = diagnostics.filter((diagnostic) => diagnostic.severity === severity).length
        return number ? [make('span', { className: severity }, `${count(number)} ${named(number)}`)] : []
      })
      counts.replaceChildren(...parts)
      fill(program, diagnostics, SHOWN)
    },
  }
}
