// A button that opens the list of what pointer and keys do with a picture.

import { make } from './dom.js'
import { say } from './texts.js'

/** Adds the button to a toolbar and the list below what it is about. @param {HTMLElement} toolbar @param {HTMLElement} picture @param {string} text  a line for each: what is done, a bar, what it does */
export function offerShortcuts(toolbar, picture, text) {
  const rows = text.split('\n').flatMap((line) => {
    const [how, what] = line.split('|')
    return [make('dt', {}, how), make('dd', {}, what)]
  })
  const list = make('dl', { className: 'shortcuts', hidden: true }, ...rows)
  const button = make('button', { type: 'button', title: say.charts.shortcuts, className: 'ask' }, '?')
  button.setAttribute('aria-label', say.charts.shortcuts)
  button.setAttribute('aria-expanded', 'false')
  button.addEventListener('click', () => {
    list.hidden = !list.hidden
    button.setAttribute('aria-expanded', String(!list.hidden))
  })
  toolbar.append(button)
  picture.before(list)
}
