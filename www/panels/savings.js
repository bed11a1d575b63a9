// What would save time, the most first: each is simulated while the page has nothing else to do, tried with one click and taken
// back with another.

import { isStill } from '../columns.js'
import { find, make, scroll } from '../dom.js'
import { Ended } from '../engine.js'
import { amount, count, difference, percent } from '../format.js'
import { nameOf } from '../job/names.js'
import { compute } from '../job/other.js'
import { ideasFor, lacking, savedBy } from '../job/savings.js'
import { say } from '../texts_later.js'

/** @import { Engine } from "../engine.js" */
/** @import { OfOperation } from "../job/document.js" */
/** @import { Idea } from "../job/savings.js" */
/** @import { Step } from "../state/store.js" */
/** @import { Column, State, Values } from "../types.js" */

/** What saves less, s, saves nothing. */
const MIN_SAVED_S = 0.05

/**
 * @typedef {object} Actions
 * @property {(values: Values) => Step} setMachine
 * @property {(column: Column) => Step} setQuoted
 * @property {(id: number, what: Partial<OfOperation>) => Step} setOperation
 */

/** @param {HTMLElement} root @param {Engine} engine  one of its own @param {Actions} actions */
export function mount(root, engine, actions) {
  const standing = make('span', { className: 'standing small', role: 'status' })
  const bar = make('progress', { hidden: true, ariaLabel: say.savings.title })
  const back = make('button', { type: 'button' }, say.savings.back)
  const tried = make('p', { className: 'tried', role: 'status', hidden: true }, make('span', {}), ' ', back)
  const place = make('div', { className: 'result' })
  root.append(make('p', { className: 'help' }, say.savings.help), tried, make('p', { className: 'working' }, standing, ' ', bar), place)
  /** @type {State | undefined} */
  let state
  /** What is in sight is of. @type {unknown[]} */
  let shown = []
  /** What is being computed; empty: nothing. */
  let running = ''
  /** What cannot be computed, and why. @type {Map<string, string>} */
  const failed = new Map()
  /** What was tried last. @type {Step | undefined} */
  let step

  back.addEventListener('click', () => step?.undo())

  /** Tries an idea on the job that is open. @param {Idea} idea */
  function attempt(idea) {
    const now = state
    if (!now) return
    const { program, column, values = {} } = idea
    if (now.programs.length === 1) step = column !== undefined ? actions.setQuoted(column) : actions.setMachine(values)
    else if (column !== undefined) step = actions.setOperation(program.id, { tolerance: column ?? 'programmed' })
    else step = actions.setOperation(program.id, { machine: { start: program.machine?.start ?? String(now.machine.values.name ?? ''), values } })
    find(tried, 'span').textContent = say.savings.tried(titleOf(idea, now))
    tried.hidden = false
    back.focus()
  }

  /** What is run for an idea, to be told apart. @param {Idea} idea */
  const keyOf = ({ key, program, column, values }) => JSON.stringify([program.id, program.dialect, key, column, values])

  /** Computes the first idea of which something is missing. @param {State} now @param {Idea[]} ideas */
  async function work(now, ideas) {
    const next = ideas.find((idea) => !failed.has(keyOf(idea)) && lacking(now, idea))
    const key = next ? keyOf(next) : ''
    if (key === running) return
    stop()
    if (!next) return
    running = key
    const { job, operation } = /** @type {NonNullable<ReturnType<typeof lacking>>} */ (lacking(now, next))
    try {
      await compute(engine, now, job, operation)
    } catch (error) {
      if (error instanceof Ended && error.kind === 'cancelled') return
      failed.set(key, error instanceof Error ? error.message : String(error))
    }
    if (running !== key) return
    running = ''
    shown = []
    update(state)
  }

  function stop() {
    if (running === '') return
    running = ''
    engine.end()
  }

  /** @param {State | undefined} now */
  function update(now) {
    state = now
    if (step && !step.isLast()) tried.hidden = true
    root.hidden = !now || now.programs.length === 0 || now.programs.every(({ outcome }) => isStill(outcome))
    const isOpen = root.classList.contains('open') && !root.hidden
    // The page's own results come first.
    if (!now || !isOpen || now.progress || now.paused || !now.price) {
      if (isOpen) standing.textContent = say.common.computing
      return stop()
    }
    const ideas = now.programs.flatMap((program) => (isStill(program.outcome) ? [] : ideasFor(now, program)))
    const of = [now.lengthUnit, now.price, now.cut, running, ...ideas.map(keyOf)]
    if (of.length !== shown.length || of.some((value, index) => value !== shown[index])) {
      shown = of
      fill(now, ideas)
    }
    work(now, ideas)
  }

  /** @param {State} now @param {Idea[]} ideas */
  function fill(now, ideas) {
    const known = ideas.flatMap((idea) => {
      const saved = savedBy(now, idea)
      return saved ? [{ idea, ...saved }] : []
    })
    const gains = known.filter(({ seconds }) => seconds >= MIN_SAVED_S).sort((a, b) => b.seconds - a.seconds)
    const done = known.length + failed.size
    bar.hidden = done >= ideas.length
    bar.max = ideas.length
    bar.value = done
    standing.textContent = bar.hidden ? '' : say.savings.computing(count(done), count(ideas.length))
    const none = known.filter(({ seconds }) => seconds < MIN_SAVED_S).map(({ idea }) => titleOf(idea, now))
    const report = /** @type {NonNullable<State["price"]>} */ (now.price).report
    const hasPrice = report.addends.length > 0
    const rows = gains.map(({ idea, seconds, money }) => {
      const go = make('button', { type: 'button' }, say.savings.attempt)
      go.setAttribute('aria-label', say.savings.attemptThis(titleOf(idea, now)))
      go.addEventListener('click', () => attempt(idea))
      const cells = [difference(-seconds), percent(-seconds / report.cycle_time_s), ...(hasPrice ? [`−${amount(Math.max(money, 0), report.decimals)}`] : [])]
      const of = now.programs.length > 1 ? [make('span', { className: 'of small' }, nameOf(idea.program))] : []
      return make('tr', {}, make('th', { scope: 'row' }, make('span', {}, idea.title), ...of), ...cells.map((cell) => make('td', {}, cell)), make('td', {}, go))
    })
    const parts = say.quote.parts(report.batch.quantity, count(report.batch.quantity))
    const titles = [say.savings.change, say.savings.perPart, '%', ...(hasPrice ? [[parts, report.currency].filter(Boolean).join(', ')] : []), '']
    const head = make('tr', {}, ...titles.map((title) => (title ? make('th', { scope: 'col' }, title) : make('td', {}))))
    const table = make('table', {}, make('thead', {}, head), make('tbody', {}, ...rows))
    table.setAttribute('aria-label', say.savings.title)
    place.replaceChildren(
      ...(rows.length > 0 ? [scroll(table)] : []),
      ...(bar.hidden && rows.length === 0 ? [make('p', {}, say.savings.nothing)] : []),
      ...(bar.hidden && none.length > 0 ? [make('p', { className: 'help' }, say.savings.noGain(none.join('; ')))] : []),
      ...[...new Set(failed.values())].map((why) => make('p', { className: 'fault' }, say.compare.failed(why))),
    )
  }

  return { update }
}

/** An idea with its operation, where there are several. @param {Idea} idea @param {State} state */
const titleOf = ({ title, program }, state) => (state.programs.length > 1 ? `${title} (${nameOf(program)})` : title)
