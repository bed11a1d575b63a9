// The answer: the cycle time of a part at the tolerance that is quoted, what CAM says, what is in doubt, and what other tolerances
// would change. Several programs make a part together; the operation in sight then has a line of its own.

import { columnKey, columnLabel, columnsOf, cycleOf, isJob, isStill, machineOf, programInSight, quotedColumn } from '../columns.js'
import { find, make, write } from '../dom.js'
import { between, count, duration, percent, signed, seconds, worded } from '../format.js'
import { nameOf } from '../job/names.js'
import { say } from '../texts.js'

/** @import { Program, RunSummary, State } from "../types.js" */

/** CAM's estimate agrees where it is this close, as a part of the time. */
const AGREES = 0.005

/**
 * @param {HTMLElement} root
 * @param {{setQuoted(column: import("../types.js").Column): void, openPanel(id: string): void}} actions
 */
export function mount(root, actions) {
  const [figures, time, one, others, why] = ['.figures', '.time', '.one', '.others', '.why'].map((selector) => find(root, selector))
  const [range, cam, doubt] = ['.range', '.cam', '.doubt'].map((selector) => find(root, selector))
  /** What is in sight is of. @type {unknown[]} */
  let shown = []
  /** The other tolerances in sight, and what each would change. */
  let compared = ''

  /** Puts words beside a figure, or takes it away. @param {HTMLElement} figure @param {(Node | string)[]} words */
  function put(figure, ...words) {
    figure.hidden = words.length === 0
    find(figure, 'p').replaceChildren(...words)
  }

  /** The time of a part, with all that stands beside it. @param {State} state @param {RunSummary[]} runs  of all operations */
  function fill(state, runs) {
    const report = state.price?.report
    const cycle = isJob(state) ? report?.cycle_time_s : runs[0]?.cycle_time_s
    const programmed = isJob(state) ? report?.programmed_time_s : programInSight(state)?.outcome?.summary.programmed_time_s
    write(time, cycle === undefined ? '…' : duration(cycle))
    const ends = cycle === undefined ? undefined : report?.cycle_time_range_s
    put(range, ...(ends ? [between(ends, duration)] : []))
    put(cam, ...(programmed === undefined ? [] : [duration(programmed), ' ', make('span', { className: 'short' }, short(programmed, cycle))]))
    const reasons = runs.flatMap(({ trust }, index) => trust.reasons.map((reason) => (isJob(state) ? `${nameOf(state.programs[index])}: ${reason}` : reason)))
    const bound = runs.reduce((sum, { trust }) => sum + trust.seconds_in_doubt, 0)
    put(
      doubt,
      ...unsure(
        reasons,
        bound,
        runs.every(({ trust }) => trust.bounded),
      ),
    )
    figures.classList.toggle('doubtful', runs.some(isDoubtful))
  }

  /** The operation in sight of a job. @param {State} state @param {Program} program */
  function fillOne(state, program) {
    const run = program.outcome?.runs.get(quotedColumn(state, program))?.summary
    const cycle = cycleOf(state, program)
    const words = isStill(program.outcome)
      ? [whyStill(program)]
      : run && program.outcome && cycle !== undefined
        ? [
            make('b', { className: isDoubtful(run) ? 'doubtful' : '' }, duration(cycle)),
            ` · ${say.results.cam} ${duration(program.outcome.summary.programmed_time_s)} ${short(program.outcome.summary.programmed_time_s, run.cycle_time_s)}`,
          ]
        : [program.failure ? say.program.failed : say.common.computing]
    one.replaceChildren(make('span', {}, nameOf(program)), ' ', ...words)
  }

  /** What another tolerance would change, s, and the way to quote it. @param {import("../types.js").Column} column @param {number | undefined} by */
  function against(column, by) {
    const button = make('button', { type: 'button', title: say.results.quoteIt }, say.results.at(columnLabel(column)), make('b', {}, by === undefined ? '…' : signed(by)))
    button.addEventListener('click', () => {
      actions.setQuoted(column)
      others.querySelector('button')?.focus()
    })
    return button
  }

  /** Why there is less than all: what is still computed, what is of another machine, and lines that do not run. @param {State} state @param {Program} program @param {boolean} isStale */
  function reasons(state, program, isStale) {
    if (isStale) return [outOfDate(state)]
    const failed = state.programs.filter((other) => other.failure)
    if (isJob(state) && failed.length > 0) return [say.results.failed(failed.map(nameOf).join(', '))]
    const { outcome } = program
    if (!outcome) return [state.progress ? say.common.computing : say.common.notComputed]
    const errors = outcome.summary.diagnostics.filter(({ severity }) => severity === 'error').length
    if (errors === 0) return []
    const link = make('button', { type: 'button', className: 'plain errors' }, say.results.notRun(errors, count(errors)))
    link.addEventListener('click', () => actions.openPanel('diagnostics'))
    return [link]
  }

  return {
    /** @param {State} state */
    update(state) {
      const program = programInSight(state)
      if (!program) return
      const isStale = state.programs.some((other) => other.outcome && other.outcome.motion !== machineOf(state, other).motion)
      root.classList.toggle('stale', isStale)
      const columns = columnsOf(state, program)
      const column = quotedColumn(state, program)
      const each = state.programs.flatMap((other) => [other, nameOf(other), other.failure, other.outcome, quotedColumn(state, other), ...columns.map((one) => other.outcome?.runs.get(one))])
      // An entry of the price changes no time, and nothing is announced again.
      const { cycle_time_s, programmed_time_s, cycle_time_range_s } = state.price?.report ?? {}
      const now = [
        state.lengthUnit,
        program,
        column,
        ...columns,
        ...each,
        cycle_time_s,
        programmed_time_s,
        ...(cycle_time_range_s ?? []),
        state.fixture,
        Boolean(state.progress),
        isStale && outOfDate(state),
      ]
      if (now.length === shown.length && now.every((value, index) => value === shown[index])) return
      shown = now
      const isEmpty = !isJob(state) && isStill(program.outcome)
      const runs = state.programs.flatMap((other) => other.outcome?.runs.get(quotedColumn(state, other))?.summary ?? [])
      // The figures of before stay in sight until those of the changed machine are there.
      if (!isStale) fill(state, isEmpty ? [] : runs)
      one.hidden = !isJob(state)
      if (isJob(state)) fillOne(state, program)
      const hasRun = Boolean(program.outcome?.runs.has(column))
      const changes = columns.filter((other) => other !== column).map((other) => ({ other, by: changeAt(state, program, other) }))
      const offered = hasRun && !isEmpty && changes.some(({ by }) => by !== 0) ? changes : []
      const differences = JSON.stringify([state.lengthUnit, offered])
      if (differences !== compared) others.replaceChildren(...offered.map(({ other, by }) => against(other, by)))
      compared = differences
      why.replaceChildren(...(isEmpty ? [whyStill(program)] : reasons(state, program, isStale)))
      if (!isEmpty) return
      write(time, '–')
      put(cam)
    },
  }
}

/** Why nothing moves in a program. @param {Program} program */
const whyStill = ({ file, name }) => (file.size === 0 ? say.results.empty(name) : say.results.nothingMoves(name))

/** By how much a part takes longer where another tolerance is quoted: that of the operation in sight where it has its own, else that of the job; undefined while something is still to be computed. @param {State} state @param {Program} program  in sight @param {import("../types.js").Column} column */
function changeAt(state, program, column) {
  const isOwn = program.tolerance !== null
  const changed = isOwn ? [program] : state.programs.filter(({ tolerance }) => tolerance === null)
  const differences = changed.map((other) => {
    const next = isOwn ? column : quotedColumn({ ...state, quoted: columnKey(column) }, other)
    const [to, from] = [next, quotedColumn(state, other)].map((at) => other.outcome?.runs.get(at)?.summary.cycle_time_s)
    return to === undefined || from === undefined ? undefined : to - from
  })
  return differences.reduce((sum, by) => (sum === undefined || by === undefined ? undefined : sum + by), 0)
}

/** A cycle time is not to be relied on where so much of it is in doubt. */
const MOST_IN_DOUBT = 0.1

/** Whether a time is in so much doubt that it is no answer. @param {RunSummary} run */
export const isDoubtful = ({ cycle_time_s: cycle, trust }) => trust.seconds_in_doubt > MOST_IN_DOUBT * cycle

/** By how much a cycle time may be off, and why; a single reason says how much by itself. @param {string[]} reasons @param {number} bound  s @param {boolean} isBounded */
function unsure(reasons, bound, isBounded) {
  if (reasons.length === 0) return []
  const why = worded(reasons.join(' · '))
  const all = reasons.length > 1 ? [make('b', {}, say.results.unsure(bound > 0 ? seconds(bound) : '?', isBounded)), ' '] : []
  return [make('span', { className: 'unsure', title: why }, ...all, why)]
}

/** By how much CAM's time is short of the predicted one. @param {number} programmed @param {number | undefined} cycle */
function short(programmed, cycle) {
  const ratio = cycle === undefined ? NaN : programmed / cycle - 1
  if (!Number.isFinite(ratio) || Math.abs(ratio) < AGREES) return ''
  const written = percent(Math.abs(ratio)).replace('+', '')
  return ratio < 0 ? say.results.short(written) : say.results.long(written)
}

/** Why the results in sight are not those of the machine in the form. @param {State} state */
export function outOfDate({ machine, paused }) {
  if (machine.faults.length > 0) return say.results.ofBeforeFault
  return paused ? say.results.ofBefore : say.results.anew
}
