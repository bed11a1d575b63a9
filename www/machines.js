// Machines that are kept in the browser, as filled forms; what is in them is checked by the form when one is chosen.

import { say } from './texts.js'

/** @import { Preset, Values } from "./types.js" */

const KEY = 'truefeed.machines.1'

/** Names that this page had: what else is kept was kept by another tab. @type {Set<unknown>} */
const own = new Set()

/** Those kept, as machines to begin with. @returns {Preset[]} */
export function loadMachines() {
  const all = kept()
  all.forEach(({ name }) => own.add(name))
  return all
}

/** What the browser keeps. @returns {Preset[]} */
function kept() {
  try {
    const all = /** @type {unknown} */ (JSON.parse(localStorage.getItem(KEY) ?? '[]'))
    if (!Array.isArray(all)) return []
    const isOne = (/** @type {any} */ values) => typeof values?.name === 'string'
    return all.filter(isOne).map(keptMachine)
  } catch {
    return []
  }
}

/** A machine to begin with that is kept. @param {Values} values @returns {Preset} */
export const keptMachine = (values) => ({
  name: String(values.name),
  source: say.machine.kept,
  caveat: '',
  values,
  kept: true,
})

/** Keeps these, and those of other tabs. @param {readonly Preset[]} ours */
export function saveMachines(ours) {
  ours.forEach(({ name }) => own.add(name))
  const others = kept().filter(({ name }) => !own.has(name))
  const all = [...ours, ...others].map(({ values }) => values)
  try {
    localStorage.setItem(KEY, JSON.stringify(all))
  } catch {
    // A browser that keeps nothing still computes.
  }
}

/** A name that none of these has yet, machines, programs or recordings. @param {string} name @param {readonly {name: string}[]} others */
export function freeName(name, others) {
  const isFree = (/** @type {string} */ other) => !others.some(({ name }) => name === other)
  const stem = name.replace(/ \(\d+\)$/, '')
  let free = name
  for (let number = 2; !isFree(free); number += 1) free = `${stem} (${number})`
  return free
}
