// By what the path is coloured: the choices there are, the parts of the program, and what its colours mean.

import { make } from '../dom.js'
import { count, feedrate, number } from '../format.js'
import { operationTitle, plain, toolTitle } from '../operations.js'
import { say } from '../texts_later.js'

/** @import { PathView } from "../pkg/truefeed_whole.js" */
/** @import { Fed } from "../cutting/job.js" */
/** @import { Operation } from "../types.js" */

/** Value, title of the choice, and what stands before the scale. @type {[string, string, string][]} */
const COLORS = [
  ['feedrate', say.path.byFeedrate, say.common.feedrate],
  ['loss', say.path.byLoss, say.path.loss],
  ['lost', say.path.byLost, say.path.lost],
  ['revised', say.path.byRevised, ''],
  ['tool', say.path.byTool, say.path.tool],
  ['operation', say.path.byOperation, say.common.operation],
  ['fed', say.path.byFeedPerTooth, say.path.feedPerTooth],
]
/** So many parts are named; those beyond are told by pointing. */
const MOST_NAMED = 12

/** The choices there are. @param {Operation[]} operations @param {boolean} hasLost  a recording is there @param {boolean} isRevised  another job is compared @param {boolean} isFed  the feed per tooth is known */
export function choices(operations, hasLost, isRevised, isFed) {
  const tools = new Set(operations.map(({ tool }) => tool)).size
  /** @type {Record<string, boolean>} */
  const is = { lost: hasLost, revised: isRevised, fed: isFed, tool: tools > 1, operation: operations.length > 1 }
  return COLORS.filter(([value]) => is[value] ?? true)
}

/** What a choice is called. @param {string} by */
export const wayOf = (by) => COLORS.find(([value]) => value === by)?.[1]

/** Parts of a program, each with its name and the number of its colour. @param {string} by @param {Operation[]} operations @param {Fed[]} fed  how the teeth are fed */
export function partsOf(by, operations, fed) {
  const feeds = say.path.feeds.split('|')
  if (by === 'fed') return fed.map(({ end, feed }) => ({ name: feeds[feed], end, number: feed }))
  const tools = [...new Set(operations.map(({ tool }) => tool))]
  return operations.map((operation, index) => {
    const isTool = by === 'tool'
    const tool = toolTitle(operation)
    const name = isTool ? [tool, plain(operation.tool_name)].join(' ').trim() : `${tool} · ${operationTitle(operation)}`
    return { name, end: operation.distance_mm[1], number: isTool ? tools.indexOf(operation.tool) : index }
  })
}

/** Colours a path. @param {PathView} view @param {string} by @param {Operation[]} operations @param {Fed[]} fed */
export function color(view, by, operations, fed) {
  const isPart = ['tool', 'operation', 'fed'].includes(by)
  if (isPart) {
    const parts = partsOf(by, operations, fed)
    view.parts(
      Float64Array.from(parts, ({ end }) => end),
      Float64Array.from(parts, ({ number }) => number),
    )
  }
  view.color(isPart ? 'part' : by === 'revised' ? 'lost' : by)
}

/** What the first and the last colour stand for. @param {PathView} view @returns {[string, string]} */
export function endsOf(view) {
  const { ends, unit } = view.legend()
  if (!unit) return ['', '']
  const [first, last] = [...ends].map((end) => (unit === 'mm/min' ? feedrate(end) : `${number(end)} ${unit}`))
  return [first, last]
}

/** @param {HTMLElement} legend @param {PathView} view @param {string} by @param {Operation[]} operations @param {string | undefined} other  the name of the job that is compared @param {Fed[]} fed */
export function fillLegend(legend, view, by, operations, other, fed) {
  const { colors, unit } = view.legend()
  const title = by === 'revised' ? say.path.revised(other) : (COLORS.find(([value]) => value === by)?.[2] ?? '')
  const rapids = make('span', { className: 'dashes' })
  rapids.setAttribute('aria-hidden', 'true')
  legend.replaceChildren(make('span', {}, `${title}:`), ...(unit ? ramp(view, colors) : names(colors, by, operations, fed)), rapids, make('span', {}, say.path.rapid))
}

/** @param {PathView} view @param {string[]} colors */
function ramp(view, colors) {
  // A scale rises from the left, whichever end the colours begin at.
  const [from, to] = view.legend().ends
  const rising = (/** @type {string[]} */ all) => (from > to ? [...all].reverse() : all)
  const ramp = make('span', { className: 'ramp' }, ...rising(colors).map((color) => swatch('span', color)))
  ramp.setAttribute('aria-hidden', 'true')
  const [first, last] = rising(endsOf(view))
  return [make('span', {}, first), ramp, make('span', {}, last)]
}

/** @param {string[]} colors @param {string} by @param {Operation[]} operations @param {Fed[]} fed */
function names(colors, by, operations, fed) {
  const all = new Map(partsOf(by, operations, fed).map(({ name, number }) => [number, name]))
  const named = [...all].slice(0, MOST_NAMED).map(([number, name]) => make('span', { className: 'part' }, swatch('i', colors[number % colors.length]), name))
  return all.size > named.length ? [...named, say.path.andMore(count(all.size - named.length))] : named
}

/** @param {"span" | "i"} kind @param {string} color */
function swatch(kind, color) {
  const element = make(kind, {})
  element.style.background = color
  return element
}
