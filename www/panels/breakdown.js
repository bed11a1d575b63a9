// Where the time goes: by kind for every tolerance, by operation and by tool for one of them.

import { columnLabel, columnsOf } from '../columns.js'
import { find, make } from '../dom.js'
import { count, difference, millimetres, number, seconds } from '../format.js'
import { say } from '../texts_later.js'

/** @import { Breakdown, Column, Cut, CutOfOperation, Operation, Part, Place, RunSummary, State, Tool } from "../types.js" */

/** @type {[keyof import("../types.js").Functions, string][]} */
const FUNCTIONS = [
  ['spindle_s', say.breakdown.spindle],
  ['coolant_s', say.breakdown.coolant],
  ['stops_s', say.breakdown.programStops],
  ['pallet_s', say.breakdown.palletChanges],
  ['clamp_s', say.breakdown.clamping],
  ['m_words_s', say.breakdown.otherWords],
  ['halts_s', say.breakdown.halts],
  ['start_s', say.breakdown.programStart],
]

/** The kinds of time in the order of a breakdown; machine functions are the parts of what is other. @type {[string, (breakdown: Breakdown) => number][]} */
const KINDS = [
  [say.common.cutting, ({ cutting_s }) => cutting_s],
  [say.common.rapid, ({ rapid_s }) => rapid_s],
  [say.common.dwell, ({ dwell_s }) => dwell_s],
  [say.breakdown.toolChanges, ({ tool_change_s }) => tool_change_s],
  ...FUNCTIONS.map(
    ([key, title]) =>
      /** @type {[string, (breakdown: Breakdown) => number]} */ ([title, ({ other }) => other[key]]),
  ),
]

/** What is told of an operation or a tool. @type {[string, (part: Part) => string][]} */
const COLUMNS = [
  [say.common.time, ({ time_s }) => seconds(time_s)],
  [say.common.programmed, ({ programmed_time_s }) => seconds(programmed_time_s)],
  [say.common.lost, ({ lost_s }) => difference(lost_s)],
  [say.common.cutting, ({ breakdown }) => seconds(breakdown.cutting_s)],
  [say.common.rapid, ({ breakdown }) => seconds(breakdown.rapid_s)],
  [say.common.dwell, ({ breakdown }) => seconds(breakdown.dwell_s)],
  [say.common.toolChange, ({ breakdown }) => seconds(breakdown.tool_change_s)],
  [say.common.other, ({ breakdown }) => seconds(breakdown.other_s)],
  [say.breakdown.feedPath, ({ feed_mm }) => millimetres(feed_mm)],
  [say.breakdown.rapidPath, ({ rapid_mm }) => millimetres(rapid_mm)],
  [say.breakdown.blocks, ({ blocks }) => count(blocks)],
]

/** A computed column of the results, and its place among them, which gives its colour. @typedef {{column: Column, index: number, run: RunSummary}} ColumnRun */

/** What a cut adds for an operation. @type {[string, (part: CutOfOperation) => string][]} */
const CUT_COLUMNS = [
  [say.common.removedMm, ({ removed_mm3: removed }) => number(removed)],
  [say.common.peakPowerW, ({ peak_power_w: peak }) => number(peak.value)],
  [say.common.peakForceN, ({ peak_force_n: peak }) => number(peak.value)],
]

/**
 * @param {HTMLElement} root
 * @param {{show(place: Pick<Place, "distance_mm">): void}} actions
 */
export function mount(root, actions) {
  const kinds = find(root, '.kinds')
  const parts = find(root, '.parts')
  const chosen = /** @type {HTMLSelectElement} */ (find(root, 'select'))
  /** What is in sight; runs are told apart by being other objects. @type {ColumnRun[]} */
  let shown = []
  /** The cut of the program in sight, if there is one. @type {Cut | null} */
  let cut = null

  chosen.addEventListener('change', fill)

  /** Operations and tools at the chosen tolerance. */
  function fill() {
    const one = shown[chosen.selectedIndex]
    if (!one) return parts.replaceChildren()
    const { column, run } = one
    const cuts = cut?.column === column ? cut.operations : null
    const operations = run.operations.map((operation, index) => {
      const cells = row(begin(operation), name(operation), operation)
      const own = cuts?.[index]
      if (cuts) cells.append(...CUT_COLUMNS.map(([, text]) => make('td', {}, own ? text(own) : '–')))
      return cells
    })
    const tools = run.tools.map((tool) => row(toolTitle(tool), toolName(tool), tool))
    parts.replaceChildren(
      table(say.breakdown.operations, [say.common.line, say.common.operation], operations, cuts ? CUT_COLUMNS.map(([title]) => title) : []),
      ...(run.tools.length > 1 ? [table(say.breakdown.tools, [say.breakdown.tool, say.breakdown.name], tools)] : []),
    )
  }

  /** The line that begins an operation, and the way to it in the chart. @param {Operation} operation */
  function begin(operation) {
    const line = String(operation.line)
    if (operation.blocks === 0) return line
    const go = make('button', { type: 'button', title: say.common.showInChart }, line)
    go.setAttribute('aria-label', say.breakdown.showLine(line))
    go.addEventListener('click', () => actions.show(operation))
    return go
  }

  return {
    /** @param {State} state */
    update(state) {
      const outcome = state.programs.find(({ id }) => id === state.selected)?.outcome
      const now = columnsOf(state, outcome).flatMap((column, index) => {
        const run = outcome?.runs.get(column)?.summary
        return run ? [{ column, index, run }] : []
      })
      root.hidden = now.length === 0
      root.classList.toggle('stale', Boolean(outcome) && outcome?.motion !== state.machine.motion)
      const cutNow = cutOf(state)
      if (now.length === shown.length && now.every((one, at) => one.run === shown[at].run && one.index === shown[at].index) && cut === cutNow) return
      cut = cutNow
      const before = chosen.value
      shown = now
      kinds.replaceChildren(kindsTable(shown))
      chosen.replaceChildren(...shown.map(({ column }) => make('option', {}, columnLabel(column))))
      if (shown.some(({ column }) => columnLabel(column) === before)) chosen.value = before
      fill()
    },
  }
}

/** The cut of the program in sight on the machine as it is. @param {State} state */
function cutOf({ cut, selected, programs, machine }) {
  const program = programs.find(({ id }) => id === selected)
  const isOf = cut?.program === program?.id && cut?.dialect === program?.dialect && cut?.motion === machine.motion
  return isOf ? cut : null
}

/** Seconds by kind, a column a tolerance; kinds that take no time at any are left out. @param {ColumnRun[]} shown */
function kindsTable(shown) {
  const titles = shown.map(({ column, index }) =>
    make('th', { scope: 'col' }, make('span', { className: `swatch curve-${index}` }), columnLabel(column)),
  )
  const runs = shown.map(({ run }) => run)
  const head = make('tr', {}, make('th', { scope: 'col' }, say.breakdown.timeByKind), ...titles)
  const rows = KINDS.filter(([, time]) => runs.some(({ breakdown }) => time(breakdown) !== 0)).map(([title, time]) =>
    make(
      'tr',
      {},
      make('th', { scope: 'row' }, title),
      ...runs.map(({ breakdown }) => make('td', {}, seconds(time(breakdown)))),
    ),
  )
  return scrolling(make('table', {}, make('thead', {}, head), make('tbody', {}, ...rows)))
}

/** @param {string} caption @param {[string, string]} first @param {HTMLElement[]} rows @param {string[]} more  titles */
function table(caption, [first, second], rows, more = []) {
  const titles = [first, second, ...COLUMNS.map(([title]) => title), ...more].map((title) => make('th', { scope: 'col' }, title))
  const head = make('thead', {}, make('tr', {}, ...titles))
  return scrolling(make('table', {}, make('caption', {}, caption), head, make('tbody', {}, ...rows)))
}

/** @param {HTMLTableElement} table */
function scrolling(table) {
  const caption = table.caption?.textContent ?? say.breakdown.timeByKind
  const place = make('div', { className: 'scroll', tabIndex: 0 }, table)
  // Focus lets the keys scroll what is wider than the page.
  place.setAttribute('role', 'group')
  place.setAttribute('aria-label', caption)
  return place
}

/** @param {Node | string} first @param {string} name @param {Part} part */
function row(first, name, part) {
  const cells = COLUMNS.map(([, text]) => make('td', {}, text(part)))
  return make('tr', {}, make('th', { scope: 'row' }, first), make('td', { className: 'name' }, name), ...cells)
}

/** @param {Tool} tool */
const toolTitle = ({ tool }) => (tool === null ? say.breakdown.noneNamed : `T${tool}`)

/** @param {Tool} tool */
function toolName({ tool_name, operations }) {
  const number = `${count(operations)} ${operations === 1 ? 'operation' : 'operations'}`
  return tool_name ? `${tool_name} – ${number}` : number
}

/** @param {Operation} operation */
function name({ name, tool, tool_name }) {
  const titled = tool === null ? '' : `T${tool}${tool_name ? ` ${tool_name}` : ''}`
  return [name ?? '', titled].filter(Boolean).join(' – ') || say.common.beforeFirstTool
}
