// What the page remembers between visits: the machine and the tolerances, never a program.

/** @import { Values } from "./types.js" */

const KEY = 'truefeed.settings.1'

/** @typedef {{programmed?: boolean, tolerances?: number[], preset?: string, values?: Values}} Settings */

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
