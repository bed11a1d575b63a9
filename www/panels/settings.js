// The unit of lengths, and settings as a link or a file, written and read. Rust checks what a link or file contains.

import { find, offer } from '../dom.js'
import { say } from '../texts.js'

/** @import { LengthUnit, State } from "../types.js" */

/** What stands after the # of a link is not sent to any server. */
const MARK = '#settings='

/**
 * @typedef {object} Actions
 * @property {(word: string) => void} setLengthUnit
 * @property {() => Promise<string>} settings  their text; throws why there is none
 * @property {(text: string) => Promise<void>} takeSettings  throws why they are none
 * @property {() => void} undoSettings
 * @property {() => void} forgetSettings  those from before
 */

/** @param {HTMLElement} root @param {HTMLElement} notice @param {LengthUnit[]} lengths @param {Actions} actions */
export function mount(root, notice, lengths, actions) {
  const unit = /** @type {HTMLSelectElement} */ (find(root, '#length-unit'))
  const names = say.settings.units.split('|')
  const said = find(root, '.said')
  const shown = /** @type {HTMLInputElement} */ (find(root, '.link'))
  const file = /** @type {HTMLInputElement} */ (find(root, '#settings-file'))
  const refused = find(notice, '.refused')
  const taken = find(notice, '.taken')

  unit.addEventListener('change', () => actions.setLengthUnit(unit.value))
  find(root, '.copy').addEventListener('click', async () => {
    const text = await written()
    if (text === undefined) return
    shown.value = linkTo(text)
    shown.hidden = false
    try {
      await navigator.clipboard.writeText(shown.value)
      said.textContent = say.settings.copied
    } catch {
      shown.select()
      said.textContent = say.settings.copyFromField
    }
  })
  find(root, '.save-settings').addEventListener('click', async () => {
    const text = await written()
    if (text === undefined) return
    const { saveFile } = await import('../save.js')
    saveFile(text, 'application/json', 'truefeed-settings.json')
    said.textContent = say.settings.saved
  })
  file.addEventListener('change', async () => {
    const [chosen] = file.files ?? []
    if (!chosen) return
    await takeFile(chosen)
    file.value = ''
  })
  find(notice, '.back').addEventListener('click', () => {
    actions.undoSettings()
    find(root, '.copy').focus()
  })
  find(notice, '.stay').addEventListener('click', () => {
    actions.forgetSettings()
    find(root, '.copy').focus()
  })
  find(notice, '.dismiss').addEventListener('click', () => refuse(''))
  window.addEventListener('hashchange', fromAddress)

  async function fromAddress() {
    const text = takeFromAddress()
    if (text !== undefined) await take(text, say.settings.settingsOfLink)
  }

  /** The text of the settings; says why there is none. */
  async function written() {
    try {
      return await actions.settings()
    } catch (reason) {
      said.textContent = say.settings.cannotBeGiven(reason)
      return undefined
    }
  }

  /** Takes the settings of a file. @param {File} file */
  async function takeFile(file) {
    await take(await file.text(), say.settings.settingsOf(file.name))
  }

  /** @param {string} text @param {string} what */
  async function take(text, what) {
    try {
      await actions.takeSettings(text)
      refuse('')
    } catch (reason) {
      refuse(say.settings.cannotBeUsed(what, reason))
    }
  }

  /** @param {string} message */
  function refuse(message) {
    find(refused, 'span').textContent = message
    refused.hidden = message === ''
  }

  return {
    fromAddress,
    takeFile,
    refuse,
    /** @param {State} state */
    update({ beforeSettings, lengthUnit }) {
      offer(
        unit,
        lengths.map(({ word, symbol, feed_symbol }, index) => [word, `${names[index]} (${symbol}, ${feed_symbol})`]),
        lengthUnit,
      )
      taken.hidden = beforeSettings === null
    },
  }
}

/** The link to this page with settings. @param {string} text */
function linkTo(text) {
  // Brackets and marks are escaped as well, which programs that find links in a text would leave out at their end. What
  // stands within may be as it is, and links are a seventh shorter.
  const marked = encodeURIComponent(text).replace(/[!'()*]/g, (mark) => `%${mark.charCodeAt(0).toString(16)}`)
  const escaped = marked.replaceAll('%3A', ':').replaceAll('%2C', ',')
  return location.href.replace(/#.*$/s, '') + MARK + escaped
}

/**
 * The text of the settings in the address, which is taken out of it: none where there are none, and what cannot be
 * decoded as it stands.
 * @returns {string | undefined}
 */
function takeFromAddress() {
  const { hash } = location
  if (!hash.startsWith(MARK)) return undefined
  history.replaceState(null, '', location.href.replace(/#.*$/s, ''))
  const written = hash.slice(MARK.length)
  try {
    return decodeURIComponent(written)
  } catch {
    return written
  }
}
