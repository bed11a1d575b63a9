// What the page remembers between visits: the machine, the tolerances and the terms of the quote, never a program.

/** @import { Values } from "./types.js" */

const KEY = 'truefeed.settings.1'

/** @typedef {{programmed?: boolean, tolerances?: number[], preset?: string, values?: Values, terms?: Values, beside?: string, quoted?: string}} Settings */

/** Where the settings are that a link or file took the place of, until the user wants them back or not. */
const BEFORE = 'truefeed.settings.before.1'

/** @returns {Settings} */
export function loadSettings() {
  try {
    const settings = JSON.parse(localStorage.getItem(KEY) ?? '{}')
    const numbers = Array.isArray(settings.tolerances) && settings.tolerances.every(Number.isFinite)
    return { ...settings, tolerances: numbers && settings.tolerances.length > 0 ? settings.tolerances : undefined }
  } catch {
    return {}
  }
}

/** @param {Settings} settings */
export function saveSettings(settings) {
  try {
    localStorage.setItem(KEY, JSON.stringify(settings))
  } catch {
    // A browser that keeps nothing still computes.
  }
}

/** What the user had before settings came from a link or file. @returns {import("./types.js").Before | null} */
export function loadBefore() {
  try {
    return JSON.parse(localStorage.getItem(BEFORE) ?? 'null')
  } catch {
    return null
  }
}

/** @param {import("./types.js").Before | null} before */
export function saveBefore(before) {
  try {
    if (before) localStorage.setItem(BEFORE, JSON.stringify(before))
    else localStorage.removeItem(BEFORE)
  } catch {
    // It can be put back until the page is closed.
  }
}
