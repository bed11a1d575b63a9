// The calibration of the machine: what it stands on, what became of each parameter, the runs before and after.

import { find, make, scroll } from '../dom.js'
import { count, worded } from '../format.js'
import { usable } from '../recordings.js'
import { saveMachine } from '../save.js'
import { say } from '../texts_later.js'
import { measuredLaws } from './measured.js'

/** @import { Calibration, CalibrationReport, State } from "../types.js" */

/** @param {HTMLElement} root @param {{calibrate(): void, undoCalibration(): void}} actions */
export function mount(root, actions) {
  const start = /** @type {HTMLButtonElement} */ (find(root, '.start'))
  const place = find(root, '.result')
  /** @type {Calibration | null} */
  let shown = null
  start.addEventListener('click', () => actions.calibrate())

  /** @param {CalibrationReport} report */
  function fill(report) {
    const undo = make('button', { type: 'button', className: 'undo-calibration' }, say.common.undoMachine)
    undo.addEventListener('click', () => {
      actions.undoCalibration()
      start.focus()
    })
    const save = make('button', { type: 'button', className: 'save' }, say.common.saveMachine)
    save.addEventListener('click', () => saveMachine(report.values))
    place.replaceChildren(
      make('p', { className: 'sentence', role: 'status' }, worded(report.sentence)),
      make('p', { className: 'choices' }, save, undo),
      estimatesTable(report),
      runsTable(report),
      ...measuredLaws(report.measured),
      ...report.remarks.map((remark) => make('p', { className: 'facts' }, worded(remark))),
    )
  }

  return {
    /** @param {State} state */
    update(state) {
      const { calibration, calibrating, machine } = state
      const runs = usable(state).length
      root.hidden = state.recordings.length === 0 && !calibration
      start.disabled = runs === 0 || calibrating || machine.faults.length > 0
      start.textContent = runs < 2 ? say.calibration.startOne : say.calibration.startMany(count(runs))
      if (calibration === shown) return
      shown = calibration
      place.replaceChildren()
      if (calibration) fill(calibration.report)
    },
  }
}

/** @param {string} caption @param {string[]} titles @param {(string | Node)[][]} rows */
function table(caption, titles, rows) {
  const head = make('tr', {}, ...titles.map((title) => (title ? make('th', { scope: 'col' }, title) : make('td', {}))))
  const body = rows.map(([name, ...cells]) => make('tr', {}, make('th', { scope: 'row' }, name), ...cells.map((cell) => make('td', {}, cell))))
  const all = make('table', {}, make('caption', {}, caption), make('thead', {}, head), make('tbody', {}, ...body))
  return scroll(all)
}

/** @param {CalibrationReport} report */
function estimatesTable({ estimates }) {
  const rows = estimates.map(({ label, unit, before, after, deviation, verdict }) => [
    unit ? `${label} (${unit})` : label,
    worded(before),
    worded(deviation === null ? after : `${after} ± ${deviation}`),
    verdict,
  ])
  return table(say.calibration.parameters, ['', say.common.before, say.calibration.after, ''], rows)
}

/** @param {CalibrationReport} report */
function runsTable({ runs }) {
  const rows = runs.map(({ name, time, motion, feed, cam_feed: cam }) => [name, ...[time, motion, feed ?? '–', cam ?? '–'].map(worded)])
  return table(say.calibration.runs, ['', say.common.cycleTime, say.calibration.motion, say.calibration.feedrates, say.calibration.cam], rows)
}
