// A line that says what was done, and takes it back.

import { find } from './dom.js'

const UNDO_MS = 15_000

/** @param {HTMLElement} root */
export function mountUndo(root) {
  let timer = 0
  let putBack = () => {}
  find(root, 'button').addEventListener('click', () => {
    root.hidden = true
    putBack()
  })
  return {
    /** @param {string} text @param {() => void} back */
    offer(text, back) {
      putBack = back
      find(root, 'span').textContent = text
      root.hidden = false
      clearTimeout(timer)
      timer = window.setTimeout(() => (root.hidden = true), UNDO_MS)
    },
  }
}
