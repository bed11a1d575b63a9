// Jobs: those that are kept in this browser, with a search; a new one, a copy, a file; what is shared of a result.

import { jobFromText } from '../pkg/truefeed_whole.js'
import { columnKey } from '../columns.js'
import { make } from '../dom.js'
import { count } from '../format.js'
import { opened, written } from '../job/document.js'
import * as kept from '../job/jobs.js'
import { inMemory } from '../memory.js'
import { saveFile } from '../save.js'
import { say } from '../texts_later.js'

/** @import { NewOperation } from "../state/job.js" */
/** @import { KeptJob } from "../job/jobs.js" */
/** @import { Column, Form, Program, State } from "../types.js" */

/**
 * @typedef {object} Actions
 * @property {(job: {operations: readonly NewOperation[]}) => void} openJob
 * @property {() => void} newJob
 * @property {(what: {job?: string, fixture?: number | null}) => void} setJob
 * @property {(message: string) => void} refuse
 * @property {(id: string) => void} compare  with a kept job
 */

/** @param {HTMLElement} root  a drawer @param {Form} form @param {(program: Program) => Column} columnOf  the tolerance that is quoted @param {Actions} actions */
export function mount(root, form, columnOf, actions) {
  /** @type {State | undefined} */
  let state
  /** The kept job that is open; a change of it is kept in its place. @type {string | null} */
  let current = null
  /** @type {KeptJob[]} */
  let jobs = []

  const button = (/** @type {string} */ text, /** @type {() => unknown} */ act, className = '') => {
    const element = make('button', { type: 'button', className }, text)
    element.addEventListener('click', act)
    return element
  }
  const name = make('input', { id: 'job-name', maxLength: 200 })
  name.addEventListener('change', () => actions.setJob({ job: name.value.trim() }))
  const parts = make('input', { id: 'job-fixture', inputMode: 'numeric' })
  parts.addEventListener('change', () => actions.setJob({ fixture: wholeOf(parts.value) }))
  const search = make('input', { id: 'job-search', type: 'search' })
  search.addEventListener('input', list)
  const kind = make('select', { id: 'job-kind' }, make('option', { value: 'with' }, say.jobs.withPrograms), make('option', { value: 'without' }, say.jobs.withoutPrograms))
  const input = make('input', { type: 'file', accept: '.json,application/json', className: 'away', id: 'job-file' })
  input.addEventListener('change', async () => {
    const [file] = input.files ?? []
    if (file) await take(file, [...(input.files ?? [])])
    input.value = ''
  })
  const keepButton = button(say.jobs.keep, keep, 'main')
  const saveButton = button(say.jobs.save, save)
  const rows = make('ul', { className: 'kept' })
  const told = make('p', { className: 'small', role: 'status' })
  root.append(
    line(say.jobs.name, name),
    line(say.jobs.fixture, parts),
    make('p', { className: 'choices' }, keepButton, button(say.jobs.new, begin), make('label', { className: 'button', htmlFor: input.id }, say.jobs.open), input),
    make('p', { className: 'choices' }, saveButton, make('label', { htmlFor: kind.id, className: 'away' }, say.jobs.what), kind),
    told,
    make('h3', {}, say.jobs.kept),
    line(say.jobs.search, search),
    rows,
  )

  /** What is open as the text of a job. @param {State} now @param {boolean} hasPrograms */
  async function textOf(now, hasPrograms) {
    const operation = async (/** @type {Program} */ program) => ({
      ...program,
      column: columnOf(program),
      ...(hasPrograms ? { text: await program.file.text() } : {}),
    })
    const operations = await Promise.all(now.programs.map(operation))
    return JSON.stringify(written(now, operations, { values: now.machine.values, terms: now.terms.values }), null, 1)
  }

  /** What a file is called. @param {State} now */
  const fileName = (now) => (now.job || now.programs[0]?.name || say.jobs.unnamed).replace(/\.[^.]*$/, '').replace(/[^\p{L}\d.-]+/gu, '-')

  async function save() {
    if (!state) return
    saveFile(await textOf(state, kind.value === 'with'), 'application/json', `${fileName(state)}.job.json`)
  }

  /** Keeps what is open, in the place of what it was opened as. */
  async function keep() {
    if (!state || state.programs.length === 0) return
    current ??= crypto.randomUUID()
    await put(state, current)
    told.textContent = say.jobs.isKept(nameOf(state))
  }

  /** @param {State} now */
  const nameOf = (now) => now.job || now.programs[0]?.name || say.jobs.unnamed

  /** @param {State} now @param {string} id */
  async function put(now, id) {
    const programs = now.programs.map(({ name, file }) => ({ name, file }))
    const quantity = Number(now.terms.values.quantity ?? 1)
    const about = say.jobs.about(count(programs.length), count(quantity))
    const customer = String(now.letter.customer ?? '').split('\n')[0]
    await kept.keep({ id, name: nameOf(now), saved: Date.now(), about, customer, text: await textOf(now, false), programs })
    await reload()
  }

  function begin() {
    current = null
    actions.newJob()
  }

  /** A job of a text, as what is to be open: its tolerance is quoted, beside those that are compared already. @param {string} text */
  function readFrom(text) {
    const { tolerance, ...job } = opened(JSON.parse(jobFromText(text)), form)
    const before = state?.tolerances ?? []
    if (tolerance === 'programmed') return { ...job, quoted: columnKey(null), programmed: true }
    const compared = [...new Set([tolerance, ...before])].slice(0, Math.max(1, before.length)).sort((a, b) => a - b)
    return { ...job, tolerances: compared, quoted: columnKey(tolerance) }
  }

  /** Opens a kept job, or a copy of it. @param {KeptJob} job @param {boolean} isCopy */
  async function openKept(job, isCopy) {
    const read = readFrom(job.text)
    const programs = await inMemory(job.programs)
    const operations = read.operations.map((/** @type {any} */ one, /** @type {number} */ index) => ({ ...one, file: programs[index].file }))
    const name = isCopy ? say.jobs.copyOf(job.name) : read.job
    current = isCopy ? null : job.id
    actions.openJob({ ...read, ...(isCopy ? { job: name } : {}), operations })
    root.hidePopover()
  }

  /** Compares what is open with a kept job. @param {KeptJob} job */
  function compare(job) {
    root.hidePopover()
    actions.compare(job.id)
  }

  /** Opens the file of a job; programs that it only names are looked for among the other files. @param {File} file @param {File[]} beside */
  async function take(file, beside) {
    try {
      const read = readFrom(await file.text())
      const operations = read.operations.map((/** @type {any} */ one) => {
        const found = one.text === undefined ? beside.find((other) => other.name === one.name) : new Blob([one.text])
        if (!found) throw say.jobs.lacks(file.name, one.name)
        return { ...one, file: found }
      })
      current = null
      actions.openJob({ ...read, operations })
      told.textContent = ''
    } catch (reason) {
      if (typeof reason !== 'string') throw reason
      told.textContent = reason
      actions.refuse(reason)
    }
  }

  /** Takes a kept job out, and offers to put it back. @param {KeptJob} stored */
  async function remove(stored) {
    const job = { ...stored, programs: await inMemory(stored.programs) }
    await kept.remove(job.id)
    if (current === job.id) current = null
    told.replaceChildren(
      say.jobs.removed(job.name),
      button(say.common.undo, () =>
        kept
          .keep(job)
          .then(() => told.replaceChildren())
          .then(reload),
      ),
    )
    await reload()
  }

  async function reload() {
    // A browser that keeps nothing has no list.
    jobs = await kept.all().catch(() => [])
    list()
  }

  function list() {
    const shown = kept.found(jobs, search.value)
    const row = (/** @type {KeptJob} */ job) =>
      make(
        'li',
        {},
        make('span', { className: 'about' }, make('b', {}, job.name), ' ', [job.customer, job.about, new Date(job.saved).toLocaleDateString()].filter(Boolean).join(' · ')),
        labelled(
          button(say.jobs.openThis, () => openKept(job, false)),
          job,
        ),
        labelled(
          button(say.jobs.duplicate, () => openKept(job, true)),
          job,
        ),
        ...(state?.programs.length
          ? [
              labelled(
                button(say.jobs.compare, () => compare(job)),
                job,
              ),
            ]
          : []),
        labelled(
          button(say.jobs.remove, () => remove(job)),
          job,
        ),
      )
    rows.replaceChildren(...shown.map(row))
    if (shown.length === 0) rows.append(make('li', { className: 'small' }, jobs.length === 0 ? say.jobs.none : say.jobs.noneFound))
  }

  /** Says of which job a button is. @param {HTMLElement} element @param {KeptJob} job */
  function labelled(element, job) {
    element.setAttribute('aria-label', `${element.textContent} ${job.name}`)
    return element
  }

  reload()

  return {
    take,
    /** @param {State} now */
    update(now) {
      state = now
      if (document.activeElement !== name) name.value = now.job
      if (document.activeElement !== parts) parts.value = now.fixture ? String(now.fixture) : ''
      // A job can only be compared with one that is open.
      if (keepButton.disabled !== (now.programs.length === 0)) list()
      keepButton.disabled = saveButton.disabled = now.programs.length === 0
    },
  }
}

/** A whole number of parts; nothing where there is none. @param {string} written */
function wholeOf(written) {
  const number = Number(written)
  return Number.isInteger(number) && 0 < number && number <= 10_000 ? number : null
}

/** @param {string} label @param {HTMLElement} control */
const line = (label, control) => make('div', { className: 'field' }, make('label', { htmlFor: control.id }, label), make('span', { className: 'value' }, control))
