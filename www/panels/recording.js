// Recordings: how they come to the page. What shows them (recorded.js) is fetched with the first one.

import { find } from '../dom.js'
import { programOf, recordingOf } from '../recordings.js'
import { sample } from '../samples.js'
import { say } from '../texts.js'
import { bytesOf } from './program.js'

/** @import { State } from "../types.js" */

/** A program, its machine and a recording in which something is concealed. */
const SAMPLE = { program: 'standin.nc', recording: 'standin.csv', machine: 'standin.toml' }

/**
 * @typedef {object} Actions
 * @property {(files: {name: string, bytes: Uint8Array}[]) => void} addRecordings
 * @property {(id: number) => void} selectRecording
 * @property {(id: number, program: number) => void} setProgramOf
 * @property {(id: number, used: boolean) => void} setUsed
 * @property {(id: number, interval: number) => void} setInterval  s
 * @property {(id: number) => import('../state/store.js').Step} removeRecording
 * @property {(sample: {machine: string, program: {name: string, file: Blob}, recording: {name: string, bytes: Uint8Array}}) => Promise<void>} addSample
 */

/** @param {HTMLElement} root @param {Actions} actions */
export function mount(root, actions) {
  const input = /** @type {HTMLInputElement} */ (find(root, '#recordings'))
  const invites = [.../** @type {NodeListOf<HTMLElement>} */ (root.querySelectorAll('.invite'))]
  const orphans = find(document.body, '#welcome .orphans')
  /** What shows them, and while it is fetched the promise of it. @type {{update(state: State): void} | undefined} */
  let shown
  /** @type {Promise<void> | undefined} */
  let fetching
  /** @type {State} */
  let latest

  input.addEventListener('change', async () => {
    const files = await bytesOf([...(input.files ?? [])])
    input.value = ''
    if (files.length > 0) actions.addRecordings(files)
  })
  for (const button of document.querySelectorAll('.concealed')) {
    button.addEventListener('click', async () => {
      const [program, recording, machine] = await Promise.all([SAMPLE.program, SAMPLE.recording, SAMPLE.machine].map(sample))
      actions.addSample({
        machine: await machine.text(),
        program: { name: SAMPLE.program, file: program },
        recording: { name: SAMPLE.recording, bytes: new Uint8Array(await recording.arrayBuffer()) },
      })
    })
  }

  async function fetchShown() {
    try {
      const { mount: mountShown } = await import('./recorded.js')
      shown = mountShown(root, actions)
      shown.update(latest)
    } finally {
      fetching = undefined
    }
  }

  return {
    /** @param {State} state */
    update(state) {
      latest = state
      const waiting = state.recordings.filter((entry) => !programOf(entry, state)).map(({ name }) => name)
      orphans.textContent = waiting.length > 0 ? say.recording.orphans(waiting.join(', ')) : ''
      for (const invite of invites) invite.hidden = recordingOf(state) !== undefined
      if (shown) shown.update(state)
      else if (state.recordings.length > 0) fetching ??= fetchShown()
    },
  }
}
