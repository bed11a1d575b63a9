// The page keeps the machine, the tolerances, the terms of the quote and the unit of lengths between visits, but no program.

/** @import { Before, Form, Parameter, Values } from "./types.js" */

export const KEY = 'truefeed.settings.1'

/** @typedef {{programmed?: boolean, tolerances?: number[], preset?: string, values?: Values, terms?: Values, company?: Values, beside?: string, quoted?: string, lengthUnit?: string}} Settings */

/** Where the settings are that a link or file took the place of, until the user wants them back or not. */
export const BEFORE = 'truefeed.settings.before.1'

/** The settings of the last visit, and those before they came from a link or file. @param {Form} form @param {Parameter[]} termFields @param {number} most  tolerances @returns {Promise<{settings: Settings, before: Before | null}>} */
export async function loadSettings(form, termFields, most) {
  try {
    if (localStorage.length > 0) return (await import('./stored.js')).remembered(form, termFields, most)
  } catch {
    // A browser that keeps nothing still computes.
  }
  return { settings: {}, before: null }
}

/** @param {Settings} settings */
export function saveSettings(settings) {
  try {
    localStorage.setItem(KEY, JSON.stringify(settings))
  } catch {
    // A browser that keeps nothing still computes.
  }
}

/** @param {Before | null} before */
export function saveBefore(before) {
  try {
    if (before) localStorage.setItem(BEFORE, JSON.stringify(before))
    else localStorage.removeItem(BEFORE)
  } catch {
    // It can be put back until the page is closed.
  }
}
