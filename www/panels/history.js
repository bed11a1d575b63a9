// Undo and redo of all that the user changes, as buttons and by the keys that everybody knows.

import { find } from '../dom.js'

/** @import { History } from "../state/history.js" */

/** Where typing has an undo of its own. */
const TYPED = 'input:not([type="checkbox"], [type="file"]), textarea'

/** @param {HTMLElement} root @param {History} history @param {{undo(): void, redo(): void}} actions */
export function mount(root, history, actions) {
  const undo = /** @type {HTMLButtonElement} */ (find(root, '.undo-change'))
  const redo = /** @type {HTMLButtonElement} */ (find(root, '.redo-change'))
  undo.addEventListener('click', actions.undo)
  redo.addEventListener('click', actions.redo)
  document.addEventListener('keydown', (event) => {
    const key = event.key.toLowerCase()
    const isUndo = key === 'z' && !event.shiftKey
    const isRedo = (key === 'z' && event.shiftKey) || key === 'y'
    if (!(event.ctrlKey || event.metaKey) || event.altKey || (!isUndo && !isRedo)) return
    if (event.target instanceof Element && event.target.matches(TYPED)) return
    event.preventDefault()
    if (isUndo) actions.undo()
    else actions.redo()
  })
  return {
    update() {
      undo.disabled = !history.canUndo
      redo.disabled = !history.canRedo
      root.hidden = undo.disabled && redo.disabled
    },
  }
}
