// The bar: of what the answer is, and the doors to machine and tolerances.

import { columnLabel, columnsOf, cycleOf, isJob, programInSight, quotedColumn } from '../columns.js'
import { find } from '../dom.js'
import { count, duration, roughly } from '../format.js'
import { nameOf } from '../job/names.js'
import { say } from '../texts.js'

/** @import { Form, State } from "../types.js" */

/** A drawer takes so much, and its distance from the edge. */
const ROOM_PX = 482

/** @param {HTMLElement} root @param {Form} form */
export function mount(root, form) {
  const [job, machine, tolerance] = ['.job', '.machine', '.tolerance'].map((selector) => find(root, selector))
  const answer = find(document.body, 'header .answer')
  // The answer stays in sight where the figures have gone out of it.
  new IntersectionObserver(([{ isIntersecting }]) => (answer.hidden = isIntersecting)).observe(find(document.body, '#results .figures'))

  // A drawer opens below the button that opens it, as far as there is room.
  for (const drawer of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll('.drawer'))) {
    drawer.addEventListener('beforetoggle', () => {
      const openers = /** @type {HTMLElement[]} */ ([...document.querySelectorAll(`.pick[popovertarget="${drawer.id}"]`)])
      const opener = openers.find((one) => one.checkVisibility()) ?? openers[0]
      const left = Math.max(12, Math.min(opener.getBoundingClientRect().left, window.innerWidth - ROOM_PX))
      drawer.style.setProperty('--at', `${left}px`)
    })
  }

  /** @param {HTMLElement} button @param {string} name @param {string} more */
  function put(button, name, more) {
    find(button, '.name').textContent = name
    find(button, '.small').textContent = more
    button.title = `${name} ${more}`
  }

  return {
    /** @param {State} state */
    update(state) {
      const program = programInSight(state)
      const called = state.job || (state.programs.length === 1 && program ? nameOf(program) : say.bar.unnamed)
      put(job, called, state.programs.length > 1 ? say.bar.operations(count(state.programs.length)) : '')
      const cycle = isJob(state) ? state.price?.report.cycle_time_s : program && cycleOf(state, program)
      answer.textContent = cycle === undefined ? '…' : duration(cycle)
      const { values, preset, faults } = state.machine
      const ratio = ratioOf(state)
      const known = ratio === undefined ? say.bar.unknown : say.bar.within(roughly(100 * ratio))
      const isOwn = Boolean(form.presets[preset].kept || state.calibration)
      put(machine, String(values.name ?? ''), faults.length > 0 ? say.bar.fault : isOwn ? known : say.bar.notCalibrated(known))
      machine.classList.toggle('fault', faults.length > 0)
      const columns = columnsOf(state, program)
      const quoted = quotedColumn(state, program)
      const others = columns.filter((column) => column !== quoted).map(columnLabel)
      const isOwnTolerance = program && program.tolerance !== null
      put(tolerance, columnLabel(quoted), isOwnTolerance ? say.bar.ofOperation : others.length > 0 ? say.bar.compared(others.join(' · ')) : '')
    },
  }
}

/** How far off a cycle time on the machine of the form may be, as a part of it: that of the first operation that it runs; undefined where nobody knows. @param {State} state */
function ratioOf({ programs, price }) {
  const at = programs.findIndex(({ machine }) => machine === null)
  const { cycle_time_range_s: ends = null } = price?.report.operations[at] ?? {}
  return ends ? (ends[1] - ends[0]) / (ends[0] + ends[1]) : undefined
}
