// Where the time goes: by kind for every tolerance, by operation and by tool for one of them.

import { mountTolerance } from '../at_tolerance.js'
import { columnLabel, columnsOf, machineOf, quotedColumn } from '../columns.js'
import { find, make, scroll } from '../dom.js'
import { count, difference, lengthLabel, number, seconds } from '../format.js'
import { namedIn, plain } from '../operations.js'
import { say } from '../texts_later.js'

/** @import { Breakdown, Column, Cut, CutOfOperation, Operation, Part, Place, Program, RunSummary, State, Tool } from "../types.js" */

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
  ...FUNCTIONS.map(([key, title]) => /** @type {[string, (breakdown: Breakdown) => number]} */ ([title, ({ other }) => other[key]])),
]

/** What is told of an operation or a tool, and how it is written. @type {[string, (part: Part) => number, (value: number) => string][]} */
const COLUMNS = [
  [say.common.time, ({ time_s }) => time_s, seconds],
  [say.common.programmed, ({ programmed_time_s }) => programmed_time_s, seconds],
  [say.common.lost, ({ lost_s }) => lost_s, difference],
  [say.common.cutting, ({ breakdown }) => breakdown.cutting_s, seconds],
  [say.common.rapid, ({ breakdown }) => breakdown.rapid_s, seconds],
  [say.common.dwell, ({ breakdown }) => breakdown.dwell_s, seconds],
  [say.common.toolChange, ({ breakdown }) => breakdown.tool_change_s, seconds],
  [say.common.other, ({ breakdown }) => breakdown.other_s, seconds],
  [say.breakdown.feedPath, ({ feed_mm }) => feed_mm, lengthLabel],
  [say.breakdown.rapidPath, ({ rapid_mm }) => rapid_mm, lengthLabel],
  [say.breakdown.blocks, ({ blocks }) => blocks, count],
]

/** Those that hold anything. @param {Part[]} parts */
const columnsFor = (parts) => COLUMNS.filter(([, value]) => parts.some((part) => value(part) !== 0))

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
  /** What is in sight; runs are told apart by being other objects. @type {ColumnRun[]} */
  let shown = []
  /** The cut of the program in sight, if there is one. @type {Cut | null} */
  let cut = null
  /** @type {Column | undefined} */
  let quotedBefore
  let unitBefore = ''
  /** @type {Program | undefined} */
  let program

  const at = mountTolerance(/** @type {HTMLSelectElement} */ (find(root, 'select')), fill)

  /** Operations and tools at the chosen tolerance. */
  function fill() {
    const one = shown.find(({ column }) => column === at.column())
    if (!one) return parts.replaceChildren()
    const { column, run } = one
    const cuts = cut?.column === column ? cut.operations : null
    const told = columnsFor(run.operations)
    const operations = namedIn(program, run.operations).map((operation, index) => {
      const cells = row(begin(operation), name(operation), operation, told)
      const own = cuts?.[index]
      if (cuts) cells.append(...CUT_COLUMNS.map(([, text]) => make('td', {}, own ? text(own) : '–')))
      return cells
    })
    const tools = run.tools.map((tool) => row(toolTitle(tool), toolName(tool), tool, told))
    parts.replaceChildren(
      table(say.breakdown.operations, [say.common.line, say.common.operation], told, operations, cuts ? CUT_COLUMNS.map(([title]) => title) : []),
      ...(run.tools.length > 1 ? [table(say.breakdown.tools, [say.breakdown.tool, say.breakdown.name], told, tools)] : []),
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
      program = state.programs.find(({ id }) => id === state.selected)
      const outcome = program?.outcome
      const now = columnsOf(state, program).flatMap((column, index) => {
        const run = outcome?.runs.get(column)?.summary
        return run ? [{ column, index, run }] : []
      })
      root.hidden = now.length === 0
      root.classList.toggle('stale', Boolean(outcome) && outcome?.motion !== machineOf(state).motion)
      const cutNow = cutOf(state)
      const quoted = quotedColumn(state, program)
      if (
        now.length === shown.length &&
        now.every((one, index) => one.run === shown[index].run && one.index === shown[index].index) &&
        cut === cutNow &&
        quoted === quotedBefore &&
        state.lengthUnit === unitBefore
      )
        return
      cut = cutNow
      shown = now
      quotedBefore = quoted
      unitBefore = state.lengthUnit
      kinds.replaceChildren(kindsTable(shown))
      at.update(
        shown.map(({ column }) => column),
        quoted,
      )
      fill()
    },
  }
}

/** The cut of the program in sight on the machine as it is. @param {State} state */
function cutOf(state) {
  const { cut, selected, programs } = state
  const program = programs.find(({ id }) => id === selected)
  const isOf = cut?.program === program?.id && cut?.dialect === program?.dialect && cut?.motion === machineOf(state).motion
  return isOf ? cut : null
}

/** Seconds by kind, a column a tolerance; kinds that take no time at any are left out. @param {ColumnRun[]} shown */
function kindsTable(shown) {
  const titles = shown.map(({ column, index }) => make('th', { scope: 'col' }, make('span', { className: `swatch curve-${index}` }), columnLabel(column)))
  const runs = shown.map(({ run }) => run)
  const head = make('tr', {}, make('th', { scope: 'col' }, say.breakdown.timeByKind), ...titles)
  const rows = KINDS.filter(([, time]) => runs.some(({ breakdown }) => time(breakdown) !== 0)).map(([title, time]) =>
    make('tr', {}, make('th', { scope: 'row' }, title), ...runs.map(({ breakdown }) => make('td', {}, seconds(time(breakdown))))),
  )
  return scroll(make('table', {}, make('thead', {}, head), make('tbody', {}, ...rows)))
}

/** @param {string} caption @param {[string, string]} first @param {typeof COLUMNS} told @param {HTMLElement[]} rows @param {string[]} more  titles */
function table(caption, [first, second], told, rows, more = []) {
  const titles = [first, second, ...told.map(([title]) => title), ...more].map((title) => make('th', { scope: 'col' }, title))
  const head = make('thead', {}, make('tr', {}, ...titles))
  return scroll(make('table', {}, make('caption', {}, caption), head, make('tbody', {}, ...rows)))
}

/** @param {Node | string} first @param {string} name @param {Part} part @param {typeof COLUMNS} told */
function row(first, name, part, told) {
  const cells = told.map(([, value, write]) => make('td', {}, write(value(part))))
  return make('tr', {}, make('th', { scope: 'row' }, first), make('td', { className: 'name' }, name), ...cells)
}

/** @param {Tool} tool */
const toolTitle = ({ tool }) => (tool === null ? say.breakdown.noneNamed : `T${tool}`)

/** @param {Tool} tool */
function toolName({ tool_name, operations }) {
  const number = say.breakdown.operationsOf(operations, count(operations))
  return tool_name ? `${plain(tool_name)} – ${number}` : number
}

/** @param {Operation} operation */
function name({ name, tool, tool_name }) {
  const titled = tool === null ? '' : `T${tool} ${plain(tool_name)}`.trim()
  return [plain(name), titled].filter(Boolean).join(' – ') || say.common.beforeFirstTool
}
