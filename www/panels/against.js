// Two jobs compared: the one that is open with another, by operation and together; and the program in sight with its other revision.

import { fileKind, sniffedBytes } from '../pkg/truefeed_whole.js'
import { machineOf, quotedColumn } from '../columns.js'
import { find, make, scroll } from '../dom.js'
import { Ended } from '../engine.js'
import { amount, clock, difference, percent, priced, signed } from '../format.js'
import { all as allKept, jobOf } from '../job/jobs.js'
import { compute, fromText, machineText, onMachine, pricedOther, takenBy, withPrograms } from '../job/other.js'
import { inMemory } from '../memory.js'
import { say } from '../texts_later.js'
import * as revisionsPanel from './revisions.js'

/** @import { Engine } from "../engine.js" */
/** @import { OtherJob, Taken } from "../job/other.js" */
/** @import { Difference, Form, JobComparison, OperationPair, Revised, RevisionsReport, State } from "../types.js" */

/** What is compared with, for the state as it is. @typedef {(state: State) => OtherJob} Source */

/**
 * @param {HTMLElement} root
 * @param {Engine} engine
 * @param {Form} form
 * @param {{select(id: number): void, mark(stretch: [number, number]): void, setRevised(revised: Revised | null): void}} actions
 */
export function mount(root, engine, form, actions) {
  /** @type {State | undefined} */
  let state
  /** @type {Source | null} */
  let source = null
  /** For what the operation that differs most has come in sight. @type {Source | null} */
  let wentFor = null
  /** What was chosen last, so that what comes late does not take its place. */
  let chosen = ''
  /** What is being computed; empty: nothing. */
  let running = ''
  /** Why nothing is computed any more. */
  let failed = ''
  /** What the tables show. @type {unknown[]} */
  let shown = []
  /** The revisions in sight, and the unit in which they are. @type {{key: string, revised: Revised, report: RevisionsReport, names: string[], unit: string} | null} */
  let found = null

  const choice = make('select', { id: 'against-with' })
  const input = make('input', { type: 'file', multiple: true, className: 'away', id: 'against-files' })
  input.setAttribute('aria-label', say.against.chooseFiles)
  const standing = make('p', { className: 'small', role: 'status' })
  const sentence = make('p', { className: 'sentence' })
  sentence.setAttribute('aria-live', 'polite')
  const tables = make('div', { className: 'tables' })
  const where = make('div', { className: 'where' })
  const revisions = revisionsPanel.mount(where)
  const files = make('optgroup', { label: say.against.files })
  const kept = make('optgroup', { label: say.jobs.kept })
  const machines = make('optgroup', { label: say.against.onMachine })
  choice.append(make('option', { value: '' }, say.against.choose), files, kept, machines)
  find(root, '.tools').append(make('label', {}, say.compare.with, ' ', choice), make('label', { className: 'button', htmlFor: input.id }, say.against.chooseFiles), input)
  root.append(make('p', { className: 'help' }, say.against.help), standing, sentence, tables, where)

  choice.addEventListener('focus', offer)
  choice.addEventListener('change', () => choose(choice.value))
  input.addEventListener('change', async () => {
    const given = [...(input.files ?? [])]
    input.value = ''
    if (given.length > 0) await takeFiles(given)
  })

  /** Offers the machines and the jobs that are kept now. */
  async function offer() {
    const option = (/** @type {string} */ value, /** @type {string} */ text) => make('option', { value }, text)
    machines.replaceChildren(...form.presets.map(({ name }) => option(`machine ${name}`, name)))
    // A browser that keeps nothing has no jobs.
    const jobs = await allKept().catch(() => [])
    kept.replaceChildren(...jobs.map(({ id, name }) => option(`kept ${id}`, name)))
    for (const group of [files, kept, machines]) group.hidden = group.childElementCount === 0
    choice.value = chosen
  }

  /** Compares with one of the choices. @param {string} value */
  async function choose(value) {
    chosen = value
    const name = value.slice(value.indexOf(' ') + 1)
    if (value === '') return begin(null)
    if (value.startsWith('files ')) return begin(sources.get(value) ?? null)
    if (value.startsWith('machine ')) {
      const preset = form.presets.find((one) => one.name === name)
      return begin(preset ? (now) => onMachine(now, preset) : null)
    }
    const job = await jobOf(name)
    if (chosen !== value || !job) return
    const programs = await inMemory(job.programs)
    const other = fromText(job.text, form, (_, index) => programs[index].file)
    begin(() => ({ ...other, job: job.name }))
  }

  /** What was given as files, by its choice. @type {Map<string, Source>} */
  const sources = new Map()

  /** Compares with the job of a file, whose programs may be among the others, or with other revisions of the programs. @param {File[]} given */
  async function takeFiles(given) {
    try {
      const kinds = await Promise.all(given.map(async (file) => fileKind(new Uint8Array(await file.slice(0, sniffedBytes()).arrayBuffer()))))
      const job = given.find((_, index) => kinds[index] === 'job')
      const programs = given.filter((_, index) => kinds[index] === 'program')
      const name = (job ? [job] : programs).map((file) => file.name).join(', ')
      if (!name) throw say.against.noPrograms
      const other = job && fromText(await job.text(), form, (wanted) => lookUp(programs, wanted))
      const value = `files ${name}`
      if (state) sources.set(value, other ? () => ({ ...other, job: other.job || name }) : withPrograms(state, programs))
      files.replaceChildren(...[...sources.keys()].map((one) => make('option', { value: one }, one.slice(one.indexOf(' ') + 1))))
      await offer()
      choice.value = value
      await choose(value)
    } catch (reason) {
      if (typeof reason !== 'string') throw reason
      chosen = choice.value = ''
      begin(null)
      standing.textContent = reason
    }
  }

  /** The program of a name; throws that it is not there. @param {File[]} programs @param {string} wanted */
  function lookUp(programs, wanted) {
    const file = programs.find(({ name }) => name === wanted)
    if (!file) throw say.against.lacks(wanted)
    return file
  }

  /** @param {Source | null} wanted */
  function begin(wanted) {
    source = wanted
    failed = ''
    stop()
    update(state)
  }

  function stop() {
    running = ''
    engine.end()
  }

  /** Shows nothing, and says why. @param {string} words */
  function clear(words) {
    standing.textContent = words
    sentence.textContent = ''
    tables.replaceChildren()
    revisions.empty()
    shown = []
    forget()
  }

  function forget() {
    found = null
    actions.setRevised(null)
  }

  /** @param {State | undefined} now */
  function update(now) {
    state = now
    if (!now || !source || now.programs.length === 0) return clear('')
    const other = source(now)
    const taken = other.operations.map((operation) => takenBy(now, other, operation))
    const at = taken.indexOf(undefined)
    if (failed) return clear(failed)
    if (at >= 0) {
      clear(say.against.computing(other.operations[at].title || other.operations[at].name))
      return run(JSON.stringify(['job', chosen, at, machineText(other, other.operations[at])]), () => compute(engine, now, other, other.operations[at]))
    }
    show(now, other, /** @type {Taken[]} */ (taken))
  }

  /** Does something in the worker, once, and then shows what there is. @param {string} key  what it is @param {() => Promise<unknown>} work */
  async function run(key, work) {
    if (running === key) return
    stop()
    running = key
    try {
      await work()
    } catch (error) {
      if (error instanceof Ended && error.kind === 'cancelled') return
      if (running === key) failed = say.compare.failed(error instanceof Error ? error.message : String(error))
    }
    if (running !== key) return
    running = ''
    update(state)
  }

  /** @param {State} now @param {OtherJob} other @param {Taken[]} taken */
  function show(now, other, taken) {
    const of = [source, now.price, ...taken.map(({ run: one }) => one)]
    const isSame = of.length === shown.length && of.every((value, index) => value === shown[index])
    if (!isSame) {
      const report = compared(now, other, taken)
      // Its own programs are still being computed, or an entry of its forms has a fault.
      if (!report) return clear(say.common.computing)
      shown = of
      fill(report, other)
      pairs = report.operations
      if (wentFor !== source && selectLargest(now)) return
    }
    standing.textContent = ''
    showRevisions(now, other)
  }

  /** @type {OperationPair[]} */
  let pairs = []

  /** The other job first, then the one that is open. @param {State} now @param {OtherJob} other @param {Taken[]} taken @returns {JobComparison | null} */
  function compared(now, other, taken) {
    try {
      const own = now.price?.job
      if (!own) return null
      const before = pricedOther(other, taken)
      const report = JSON.parse(before.comparedWith(own))
      before.free()
      return report
    } catch (faults) {
      if (typeof faults !== 'string') throw faults
      return null
    }
  }

  /** Brings the operation in sight that differs most; false where it is. @param {State} now */
  function selectLargest(now) {
    wentFor = source
    const own = pairs.filter(({ index }) => index[1] !== null)
    const largest = own.reduce((a, b) => (Math.abs(b.cycle_time_difference_s) > Math.abs(a.cycle_time_difference_s) ? b : a), own[0])
    const wanted = largest && now.programs[/** @type {number} */ (largest.index[1])]
    if (!wanted || wanted.id === now.selected) return false
    actions.select(wanted.id)
    return true
  }

  /** @param {JobComparison} report @param {OtherJob} other */
  function fill(report, other) {
    const { cycle_time_s: cycle, unit_price: price, total, set_up_s: setUp, batch_time_s: batch, currency } = report
    const name = other.job || say.against.other
    const hasPrices = 0 < price.first && 0 < price.second
    const money = (/** @type {number} */ value) => amount(value, 2)
    const change = (/** @type {number} */ by) => `${by > 0 ? '+' : by < 0 ? '−' : ''}${money(Math.abs(by))}`
    const price2 = hasPrices ? ` ${say.against.price(`${price.difference > 0 ? '+' : price.difference < 0 ? '−' : ''}${priced(Math.abs(price.difference), currency, 2)}`)}` : ''
    sentence.textContent = told(cycle, name) + price2
    const row = (/** @type {Node | string} */ title, /** @type {Difference} */ { first, second, difference: by }, write = clock, differ = signed, className = '') =>
      make('tr', { className }, make('th', { scope: 'row' }, title), ...[write(first), write(second), differ(by), percent(by / first)].map((text) => make('td', {}, text)))
    const rows = [
      ...report.operations.map(operationRow),
      row(say.against.perPart, cycle, clock, signed, 'sum'),
      row(say.against.setUp, setUp),
      row(say.against.batch, batch),
      ...(hasPrices ? [row(say.against.unitPrice(currency), price, money, change), row(say.against.total(currency), total, money, change)] : []),
    ]
    const heads = ['', name, say.against.thisJob, say.common.difference, '%'].map((title) => (title ? make('th', { scope: 'col' }, title) : make('td', {})))
    const table = make('table', {}, make('caption', {}, say.against.caption(name)), make('thead', {}, make('tr', {}, ...heads)), make('tbody', {}, ...rows))
    tables.replaceChildren(scroll(table), ...report.remarks.map((remark) => make('p', { className: 'small' }, remark)))
  }

  /** An operation, with the way to it. @param {OperationPair} pair */
  function operationRow({ name, index, cycle_time_s: times, cycle_time_difference_s: by }) {
    const own = index[1] === null ? undefined : state?.programs[index[1]]
    const go = make('button', { type: 'button', className: 'plain' }, name)
    go.addEventListener('click', () => own && actions.select(own.id))
    const cells = [...times.map((time) => (time === null ? '–' : clock(time))), difference(by), times[0] === null || times[1] === null ? '–' : percent(by / times[0])]
    return make('tr', {}, make('th', { scope: 'row' }, own ? go : name), ...cells.map((text) => make('td', {}, text)))
  }

  /** Where the program in sight differs from its other revision. @param {State} now @param {OtherJob} other */
  function showRevisions(now, other) {
    const at = now.programs.findIndex(({ id }) => id === now.selected)
    const program = now.programs[at]
    const pair = pairs.find(({ index }) => index[1] === at)
    const before = pair && pair.index[0] !== null ? other.operations[pair.index[0]] : undefined
    if (!program || !before) {
      forget()
      return revisions.empty(say.against.noPartner)
    }
    const taken = /** @type {Taken} */ (takenBy(now, other, before))
    const sides = [
      { program: before.file, machine: machineText(other, before), dialect: before.dialect, tolerance: taken.column },
      { program: program.file, machine: JSON.stringify(machineOf(now, program).values), dialect: program.dialect, tolerance: quotedColumn(now, program) },
    ]
    const key = JSON.stringify([chosen, program.id, sides, pair])
    if (found?.key === key) {
      if (found.unit === now.lengthUnit) return
      found.unit = now.lengthUnit
      return revisions.fill(found.report, found.names, actions.mark)
    }
    revisions.empty(say.common.computing)
    run(key, async () => {
      const { report, columns } = await engine.revise(sides, () => {})
      if (running !== key) return
      const revised = { program: program.id, columns, name: other.job || say.against.other }
      const names = before.name === program.name ? [revised.name, say.against.thisJob] : [before.name, program.name]
      found = { key, revised, report, names, unit: now.lengthUnit }
      revisions.fill(report, names, actions.mark)
      actions.setRevised(revised)
    })
  }

  /** By how much the job that is open takes longer. @param {Difference} cycle @param {string} name */
  function told({ first, difference: by }, name) {
    const time = signed(Math.abs(by)).replace(/^[+−]/, '')
    if (!/[1-9]/.test(time)) return say.against.asLong(name)
    return by < 0 ? say.against.shorter(time, percent(by / first), name) : say.against.longer(time, percent(by / first), name)
  }

  offer()
  return {
    update,
    /** Compares with a job that is kept. @param {string} id */
    async withKept(id) {
      await offer()
      choice.value = `kept ${id}`
      await choose(choice.value)
    },
  }
}
