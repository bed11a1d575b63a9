// A line that says what was done, and takes it back as long as it is the last change.

import { find } from './dom.js'

/** @import { Step } from "./state/store.js" */

const UNDO_MS = 15_000

/** @param {HTMLElement} root */
export function mountUndo(root) {
  let timer = 0
  /** @type {Step | undefined} */
  let done
  find(root, 'button').addEventListener('click', () => {
    root.hidden = true
    done?.undo()
  })
  return {
    /** @param {string} text @param {Step} step */
    offer(text, step) {
      done = step
      find(root, 'span').textContent = text
      root.hidden = false
      clearTimeout(timer)
      timer = window.setTimeout(() => (root.hidden = true), UNDO_MS)
    },
    /** Takes the offer away once there is something newer to take back. */
    update() {
      if (done && !done.isLast()) root.hidden = true
    },
  }
}
