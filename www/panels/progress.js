// What is being computed, how far it is, and the way to stop it.

import { find } from '../dom.js'
import { say } from '../texts.js'

/** @import { State } from "../types.js" */

/** @param {HTMLElement} root @param {{cancel(): void, resume(): void}} actions */
export function mount(root, actions) {
  const text = find(root, 'p')
  const bar = /** @type {HTMLProgressElement} */ (find(root, 'progress'))
  const button = /** @type {HTMLButtonElement} */ (find(root, 'button'))
  let paused = false
  button.addEventListener('click', () => (paused ? actions.resume() : actions.cancel()))

  return {
    /** @param {State} state */
    update(state) {
      paused = state.paused
      root.hidden = !state.progress && !paused
      bar.hidden = paused
      button.textContent = paused ? say.progress.compute : say.common.cancel
      if (paused) {
        text.textContent = say.progress.cancelled
      } else if (state.progress) {
        const { program: id, stage, part } = state.progress
        const program = state.programs.find((candidate) => candidate.id === id)
        text.textContent = program ? `${program.name}: ${stage}` : stage
        bar.value = part
      }
    },
  }
}
