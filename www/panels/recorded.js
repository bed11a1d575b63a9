// Recordings that are there: choosing and removing them, what each says first, both curves and the time lost, and where.

import { Chart } from '../pkg/truefeed.js'
import { find, make } from '../dom.js'
import { clock, count, difference, feedrate, percent, seconds, size, worded } from '../format.js'
import { lostLabel } from '../labels.js'
import { mountPlot } from '../plot.js'
import { isOfNone, isToPair, programOf, recordingOf } from '../recordings.js'
import { say } from '../texts_later.js'
import { mountUndo } from '../undo.js'
import { headOf, lineOf, rangeOf } from './chart.js'

/** @import { Filled } from "../plot.js" */
/** @import { Actions } from "./recording.js" */
/** @import { Program, Recording, State } from "../types.js" */
/** @import { Pointer } from "../pkg/truefeed.js" */

const NAMES = [say.recording.recordedCurve, say.recording.simulatedCurve]

/** @param {HTMLElement} root @param {Actions} actions */
export function mount(root, actions) {
  const list = find(root, '.pairs')
  const answer = find(root, '.answer')
  const view = find(root, '.view')
  const chosen = find(root, '.chosen')
  const tables = find(root, '.tables')
  const undo = mountUndo(find(root, '.undo'))
  const chart = new Chart()
  /** @type {Recording | undefined} */
  let recording
  /** @type {Program | undefined} */
  let program
  /** What is in sight now, so that it is made anew only when something else is to be shown. @type {unknown[]} */
  let filled = []
  /** What the list shows now. */
  let listed = ''

  const plot = mountPlot(root, chart, {
    isShown: () => Boolean(recording?.match?.report),
    words: (pointer) => words(pointer, program),
    fill: (twin) => fillChart(twin),
    chosen(pointer) {
      chosen.hidden = false
      chosen.replaceChildren(headOf(pointer.distance, pointer.programmed, pointer.rapid), ...lineOf(pointer.line, program))
    },
  })

  /** @param {Recording} removed */
  function remove(removed) {
    undo.offer(say.common.removed(removed.name), actions.removeRecording(removed.id))
    find(root, '.undo button').focus()
  }

  /** @param {State} state */
  function fillList(state) {
    const shown = JSON.stringify([
      state.recordings.map(({ id, used, program: of, found, match }) => [id, used, of, found, match?.report?.sentence, match?.refusal]),
      state.programs.map(({ id }) => id),
      recording?.id,
    ])
    if (shown === listed) return
    listed = shown
    const focused = document.activeElement?.id
    list.replaceChildren(...state.recordings.map((entry) => pair(entry, state)))
    if (focused) document.getElementById(focused)?.focus()
  }

  /** A recording with its program. @param {Recording} entry @param {State} state */
  function pair(entry, state) {
    const { id, name, used } = entry
    const choose = make(
      'button',
      { type: 'button', className: 'choose', id: `recording-${id}` },
      make('span', { className: 'file', title: name }, name),
      make('span', { className: 'about' }, standing(entry, state)),
    )
    if (entry === recording) choose.setAttribute('aria-current', 'true')
    choose.addEventListener('click', () => actions.selectRecording(id))
    const isOpen = entry.program === null || isOfNone(entry)
    const none = isOpen ? [make('option', { value: '' }, say.recording.chooseProgram)] : []
    const of = make('select', { id: `recording-${id}-program` }, ...none, ...state.programs.map((other) => make('option', { value: String(other.id) }, other.name)))
    of.setAttribute('aria-label', say.recording.programOf(name))
    of.value = isOpen ? '' : String(entry.program)
    of.addEventListener('change', () => actions.setProgramOf(id, Number(of.value)))
    const box = make('input', { type: 'checkbox', checked: used, id: `recording-${id}-used` })
    box.addEventListener('change', () => actions.setUsed(id, box.checked))
    const removal = make('button', { type: 'button', className: 'remove', title: say.common.remove }, '×')
    removal.setAttribute('aria-label', say.recording.remove(name))
    removal.addEventListener('click', () => remove(entry))
    const use = make('label', { className: 'use', title: say.recording.useTitle }, box, say.recording.use)
    return make('li', {}, choose, make('label', { className: 'of' }, say.recording.runOf, of), use, removal)
  }

  /** The time between the rows of a recording whose file does not state it. @param {Recording} entry */
  function intervalForm({ id, interval }) {
    const input = make('input', { type: 'number', id: 'interval', min: '0', step: 'any', required: true, value: interval === null ? '' : String(interval) })
    const form = make('form', { className: 'interval' }, make('label', { htmlFor: input.id }, say.recording.interval), input, make('button', { type: 'submit' }, say.common.apply))
    form.addEventListener('submit', (event) => {
      event.preventDefault()
      actions.setInterval(id, input.valueAsNumber)
    })
    return form
  }

  /** @param {Recording} entry */
  function fill(entry) {
    const { match } = entry
    const { report, refusal, columns } = match ?? {}
    const forms = refusal?.asks_interval || entry.interval !== null ? [intervalForm(entry)] : []
    chosen.hidden = true
    view.hidden = !report
    tables.replaceChildren()
    if (refusal) {
      const rest = say.recording.restStays
      answer.replaceChildren(make('p', { className: 'sentence refused' }, worded(refusal.reason)), make('p', {}, worded(refusal.advice), ' ', make('span', { className: 'small' }, rest)), ...forms)
    }
    if (!report || !columns || !program?.outcome) return
    answer.replaceChildren(
      make('p', { className: 'sentence' }, worded(report.sentence)),
      make('p', { className: 'facts' }, worded([report.aligned, ...report.measures].join(' '))),
      ...remarks(report.remarks),
      ...forms,
    )
    fillChart(chart)
    plot.fit(true)
    import('./stretches.js').then(({ partsTable, stretchesTable }) => {
      if (recording?.match === match) tables.replaceChildren(partsTable(report), stretchesTable(report, plot.show))
    })
  }

  /** Puts the comparison in sight into a chart. @param {Filled} chart */
  function fillChart(chart) {
    const columns = recording?.match?.columns
    if (!columns || !program?.outcome) return
    const { end, feedrate: feed, rapid, line } = program.outcome.steps
    const none = new Float64Array()
    chart.program(end, feed, rapid, line)
    for (const [index, name] of NAMES.entries()) {
      chart.add(name, none, none, none)
      if (index === 0) chart.fill(columns.recordedDistance, columns.recordedFeedrate, columns.recordedTime)
      else chart.fill(columns.simulatedDistance, columns.simulatedFeedrate, columns.simulatedTime)
    }
    chart.showLost(columns.lostDistance, columns.lostSeconds)
  }

  return {
    /** @param {State} state */
    update(state) {
      undo.update()
      recording = recordingOf(state)
      program = recording && programOf(recording, state)
      fillList(state)
      const match = recording?.match
      root.classList.toggle('stale', Boolean(match) && match?.motion !== state.machine.motion)
      const now = [recording, match, program?.outcome?.steps, state.lengthUnit]
      if (now.every((value, index) => value === filled[index]) && filled.length > 0) return
      filled = now
      plot.hide()
      view.hidden = true
      chosen.hidden = true
      answer.replaceChildren()
      tables.replaceChildren()
      if (recording && match) fill(recording)
      else if (recording) answer.replaceChildren(make('p', { className: 'empty' }, say.recording.comparing))
    },
  }
}

/** One line on how a recording stands. @param {Recording} entry @param {State} state */
function standing(entry, state) {
  const { match, bytes } = entry
  if (!programOf(entry, state)) return unpaired(entry, state)
  if (isOfNone(entry)) return say.recording.ofNone
  if (match?.refusal) return say.recording.notComparable
  if (!match?.report) return say.recording.waiting(size(bytes.length))
  const { recorded_s: recorded, simulated_s: simulated, time_error: error } = match.report
  return say.recording.standing(clock(recorded), difference(simulated - recorded), percent(error))
}

/** Why a recording is without a program. @param {Recording} entry @param {State} state */
function unpaired(entry, state) {
  if (state.programs.length === 0) return say.recording.dropItsProgram
  if (isToPair(entry, state)) return say.recording.pairing
  const among = state.programs.filter(({ id }) => entry.found?.among.includes(id)).map(({ name }) => name)
  return say.recording.among(among.join(', '))
}

/** @param {string[]} all */
function remarks(all) {
  if (all.length === 0) return []
  const title = say.recording.remarks(all.length, count(all.length))
  const items = all.map((remark) => make('li', {}, worded(remark)))
  return [make('details', {}, make('summary', {}, title), make('ul', {}, ...items))]
}

/** What the chart says about one distance. @param {Pointer} pointer @param {Program | undefined} program */
function words({ distance, line, programmed, rapid, curves, lost }, program) {
  const rows = curves.map(({ label, index, feedrate: feed, range, time }) =>
    make(
      'tr',
      {},
      make('th', { scope: 'row' }, make('span', { className: `swatch curve-${index}` }), label),
      make('td', {}, feedrate(feed), rangeOf(range)),
      make('td', {}, time < 60 ? seconds(time) : clock(time)),
    ),
  )
  const late = lost === undefined ? [] : [make('p', {}, say.recording.lostSoFar, make('strong', {}, lostLabel(lost)))]
  return [headOf(distance, programmed, rapid), make('table', {}, ...rows), ...late, ...lineOf(line, program)]
}
