// The diagnosis: what was left out of the machine. The balance first, as a sentence and as a waterfall, then both curves, then the
// causes, the costliest first, with what the machine would be with them.

import { Chart, markOfChart } from '../pkg/truefeed_whole.js'
import { find, make, scroll } from '../dom.js'
import { Ended } from '../engine.js'
import { count, difference, feedrate, parsed, seconds, typed, worded, wordedHtml } from '../format.js'
import { errorLabel, lostLabel } from '../labels.js'
import { mountPlot } from '../plot.js'
import { evidence, usable } from '../recordings.js'
import { saveFile, saveMachine } from '../save.js'
import { say } from '../texts_later.js'
import { headOf, lineOf, rangeOf } from './chart.js'
import { measuredLaws } from './measured.js'

/** @import { Cause, DiagnosedColumns, Diagnosis, DiagnosisReport, Form, Sides, State, Value, Values } from "../types.js" */
/** @import { Engine } from "../engine.js" */
/** @import { Filled } from "../plot.js" */
/** @import { Pointer } from "../pkg/truefeed_whole.js" */

const NAMES = [say.recording.recordedCurve, say.diagnosis.simulatedBefore, say.diagnosis.simulatedAfter]
/** Size of a chart in the report, pixels. */
const REPORT_PX = /** @type {const} */ ([1040, 560])

/**
 * @typedef {object} Actions
 * @property {() => void} diagnose
 * @property {() => void} useDiagnosis
 * @property {() => void} undoDiagnosis
 * @property {(values: Values) => void} tryValues
 * @property {() => void} undoSample
 * @property {() => void} calibrate
 * @property {(id: number) => void} select
 * @property {(stretch: [number, number]) => void} mark  shows a stretch on the path and in the charts
 */

/** @param {HTMLElement} root @param {Engine} engine  one of its own, for what is asked beside all else @param {Form} form @param {Actions} actions */
export function mount(root, engine, form, actions) {
  const start = /** @type {HTMLButtonElement} */ (find(root, '.start'))
  const why = find(root, '.why')
  const first = find(root, '.calibrate-first')
  const calibrate = /** @type {HTMLButtonElement} */ (find(first, 'button'))
  const account = find(root, '.account-place')
  const restore = find(root, '.restore')
  const outdated = find(root, '.outdated')
  const again = /** @type {HTMLButtonElement} */ (find(outdated, 'button'))
  const sentence = find(root, '.sentence')
  const choices = find(root, '.outcome')
  const view = find(root, '.view')
  const picker = find(root, '.of')
  const runs = /** @type {HTMLSelectElement} */ (find(root, '.of select'))
  const chosen = find(root, '.chosen')
  const place = find(root, '.result')
  const chart = new Chart()
  /** @type {Diagnosis | null} */
  let shown = null
  let wasUsed = false
  let unit = ''
  let run = 0

  const plot = mountPlot(root, chart, {
    isShown: () => Boolean(shown && shown.runs.length > 0),
    words: (pointer) => words(pointer, shown?.runs[run].program),
    fill(twin) {
      const columns = shown?.runs[run].columns
      if (columns) fillChart(twin, columns)
    },
    chosen(pointer) {
      chosen.hidden = false
      const head = headOf(pointer.distance, pointer.programmed, pointer.rapid)
      chosen.replaceChildren(head, ...lineOf(pointer.line, shown?.runs[run].program))
    },
  })
  calibrate.addEventListener('click', () => actions.calibrate())
  for (const button of [start, again]) button.addEventListener('click', () => actions.diagnose())
  find(restore, 'button').addEventListener('click', () => actions.undoSample())
  runs.addEventListener('change', () => draw(Number(runs.value)))

  /** Draws one of the runs. @param {number} index */
  function draw(index) {
    const columns = shown?.runs[index]?.columns
    if (!columns) return
    run = index
    runs.value = String(index)
    chosen.hidden = true
    plot.hide()
    fillChart(chart, columns)
    plot.fit(true)
  }

  /** Goes to a region in the charts. @param {number} index @param {[number, number]} distances */
  function show(index, distances) {
    if (index !== run) draw(index)
    const program = shown?.runs[index].program
    if (program) actions.select(program.id)
    actions.mark(distances)
    plot.show({ distance_mm: distances })
  }

  /** Goes to lines in the charts and on the path: of the first run that has them. @param {[number, number]} lines */
  function showLines(lines) {
    const all = shown?.runs ?? []
    const index = all.findIndex(({ columns }) => stretchOf(columns, lines))
    const stretch = all[index] && stretchOf(all[index].columns, lines)
    if (stretch) show(index, stretch)
  }

  /** @param {Diagnosis} diagnosis */
  function fill({ report, json, html, runs: all, used }) {
    sentence.textContent = worded(report.sentence)
    const use = make('button', { type: 'button', className: 'use-diagnosis' }, used ? say.common.undoMachine : say.diagnosis.useExtended)
    use.addEventListener('click', () => {
      if (used) actions.undoDiagnosis()
      else actions.useDiagnosis()
      find(root, '.use-diagnosis').focus()
    })
    const { values } = report
    const save = make('button', { type: 'button', className: 'save' }, say.common.saveMachine)
    if (values) save.addEventListener('click', () => saveMachine(values))
    const asHtml = make('button', { type: 'button', className: 'html' }, say.diagnosis.saveHtml)
    asHtml.addEventListener('click', () =>
      saveFile(
        withCharts(
          html,
          all.map(({ columns }) => columns),
        ),
        'text/html',
        'diagnosis.html',
      ),
    )
    const asJson = make('button', { type: 'button', className: 'json' }, say.diagnosis.saveJson)
    asJson.addEventListener('click', () => saveFile(json, 'application/json', 'diagnosis.json'))
    choices.replaceChildren(...(report.changes.length > 0 ? [use, save] : []), asHtml, asJson)
    runs.replaceChildren(...all.map(({ name }, index) => make('option', { value: String(index) }, name)))
    picker.hidden = all.length < 2
    account.replaceChildren(...accountOf(report))
    const causes = [...report.causes].sort((a, b) => Math.abs(b.seconds) - Math.abs(a.seconds))
    place.replaceChildren(
      ...causes.map((cause) => causeOf(cause, showLines)),
      numbersTable(report),
      regionsTable(
        report,
        all.map(({ name }) => name),
        show,
      ),
      ...(values && report.changes.length > 0 ? [whatIf(report, values)] : []),
      ...measuredLaws(report.measured),
      ...report.messages.map((message) => make('p', { className: 'facts' }, worded(message))),
      ...notShown(report),
    )
  }

  /** The changed fields, to be varied; says what a value would do to the cycle time. @param {DiagnosisReport} report @param {Values} values */
  function whatIf(report, values) {
    const answer = make('p', { className: 'what-if', role: 'status' })
    const fault = make('p', { className: 'fault', role: 'alert' })
    /** @type {Values} */
    let tried = { ...values }
    const first = shown?.runs[0]
    const before = shown?.before.values
    if (!first || !before) return answer
    const { program } = first
    const compute = async () => {
      fault.textContent = ''
      const machines = [before, values, tried].map((machine) => JSON.stringify(machine))
      try {
        const { times } = await engine.cycleTimes({ program: program.file, dialect: program.dialect, machines })
        const what = report.changes.filter(({ key }) => tried[key] !== values[key])
        const named = what.map(({ label, unit, key }) => `${written(tried[key])} ${unit} ${label.toLowerCase()}`.replace(/ +/g, ' '))
        const saved = times[1] - times[2]
        const effect = Math.abs(saved) < 0.005 ? say.diagnosis.takesAsLong : (saved > 0 ? say.diagnosis.saves : say.diagnosis.costs)(seconds(Math.abs(saved)))
        answer.textContent =
          named.length === 0
            ? say.diagnosis.asFound(program.name, seconds(times[1]), seconds(times[0]))
            : say.diagnosis.instead(named.join(', '), program.name, effect, seconds(times[2]), seconds(times[1]))
      } catch (error) {
        if (error instanceof Ended && error.kind === 'cancelled') return
        fault.textContent = `${error instanceof Error ? error.message : error}`
      }
    }
    const rows = report.changes.map(({ key, label, unit, before: was, after, number }) => {
      const input = make('input', { type: 'text', inputMode: 'decimal', size: 9, value: written(number), id: `try-${key.replaceAll('.', '-')}` })
      input.setAttribute('aria-label', say.diagnosis.tryAnother(unit ? `${label}, ${unit}` : label))
      input.addEventListener('change', () => {
        const value = parsed(input.value)
        if (!Number.isFinite(value)) {
          input.setAttribute('aria-invalid', 'true')
          fault.textContent = say.diagnosis.notNumber(label, input.value.trim())
          return
        }
        input.removeAttribute('aria-invalid')
        tried = { ...tried, [key]: value }
        compute()
      })
      return [unit ? `${label} (${unit})` : label, worded(was), worded(after), number === null ? '' : input]
    })
    const form = make('button', { type: 'button', className: 'try' }, say.common.apply)
    form.addEventListener('click', () => actions.tryValues(tried))
    compute()
    const all = table(say.diagnosis.changes, ['', say.common.before, say.diagnosis.after, say.diagnosis.whatIf], rows)
    return make('div', { className: 'trial' }, all, answer, fault, make('p', { className: 'choices' }, form))
  }

  return {
    /** @param {State} state */
    update(state) {
      const { diagnosis, diagnosing, machine, recordings, sample } = state
      const all = usable(state).length
      root.hidden = recordings.length === 0 && !diagnosis
      restore.hidden = !sample
      start.disabled = all === 0 || diagnosing || machine.faults.length > 0
      // What a preset lacks would be found first: it is no machine's own.
      const isPreset = !form.presets[machine.preset].kept && !state.calibration && !sample
      first.hidden = !isPreset || all === 0 || Boolean(diagnosis)
      calibrate.disabled = start.disabled || state.calibrating
      start.classList.toggle('main', !isPreset)
      again.disabled = start.disabled
      const change = diagnosis && !diagnosing ? changeSince(diagnosis, state) : ''
      outdated.hidden = change === ''
      find(outdated, 'span').textContent = change
      root.classList.toggle('out-of-date', change !== '')
      start.textContent = all < 2 ? say.diagnosis.diagnose : say.diagnosis.diagnoseMany(count(all))
      const refused = recordings.find(({ match }) => match?.refusal)
      why.textContent = all > 0 || !refused ? '' : say.diagnosis.refused(refused.name)
      const isOtherUnit = state.lengthUnit !== unit
      if (diagnosis === shown && (diagnosis?.used ?? false) === wasUsed && !isOtherUnit) return
      unit = state.lengthUnit
      const isOther = diagnosis !== shown && diagnosis?.runs !== shown?.runs
      shown = diagnosis
      wasUsed = diagnosis?.used ?? false
      view.hidden = !diagnosis
      if (diagnosis) fill(diagnosis)
      else {
        sentence.textContent = ''
        choices.replaceChildren()
        account.replaceChildren()
        place.replaceChildren()
      }
      if (isOther) draw(0)
      else if (isOtherUnit) draw(run)
    },
  }
}

/** What has changed since a diagnosis, as it is said; nothing where it still holds. @param {Diagnosis} diagnosis @param {State} state */
function changeSince({ motions, evidence: own }, state) {
  if (own !== evidence(state)) return say.diagnosis.otherEvidence
  return motions.includes(state.machine.motion) ? '' : say.diagnosis.otherMachine
}

/** Gives a chart the curves of a run. @param {Filled} chart @param {DiagnosedColumns} columns */
function fillChart(chart, columns) {
  const none = new Float64Array()
  chart.program(columns.end, columns.feedrate, columns.rapid, columns.line)
  for (const [at, name] of NAMES.entries()) {
    chart.add(name, none, none, none)
    chart.fill(columns.distances[at], columns.feedrates[at], columns.times[at])
  }
  chart.showLost(columns.lostDistances[0], columns.lostSeconds[0])
  chart.showLostAfter(columns.lostDistances[1], columns.lostSeconds[1])
}

/** The report with its charts. @param {string} html @param {DiagnosedColumns[]} runs */
function withCharts(html, runs) {
  const chart = new Chart()
  const whole = runs.reduce((text, columns, index) => {
    fillChart(chart, columns)
    return text.replace(markOfChart(index), () => chart.svg(...REPORT_PX) ?? '')
  }, wordedHtml(html))
  chart.free()
  return whole
}

/** What the chart says about one distance. @param {Pointer} pointer @param {import("../types.js").Program | undefined} program */
function words({ distance, line, programmed, rapid, curves, lost, lostAfter }, program) {
  const rows = curves.map(({ label, index, feedrate: feed, range, time }) =>
    make('tr', {}, make('th', { scope: 'row' }, make('span', { className: `swatch curve-${index}` }), label), make('td', {}, feedrate(feed), rangeOf(range)), make('td', {}, seconds(time))),
  )
  const both = [lost, lostAfter].flatMap((value) => (value === undefined ? [] : [lostLabel(value)]))
  const late = both.length === 0 ? [] : [make('p', {}, say.diagnosis.lostBothSoFar, make('strong', {}, both.join(' → ')))]
  return [headOf(distance, programmed, rapid), make('table', {}, ...rows), ...late, ...lineOf(line, program)]
}

/** A value as it is typed. @param {Value} value */
const written = (value) => (typeof value === 'number' ? typed(value) : String(value ?? '–'))

/** An id as words. @param {string} id */
const spoken = (id) => id.replaceAll('_', ' ')

/** @param {[number, number]} lines */
const range = ([from, to]) => (from === to ? `${from}` : `${from}–${to}`)

/** The stretch of lines along the path, mm; none where they are not run. @param {DiagnosedColumns} columns @param {[number, number]} lines @returns {[number, number] | undefined} */
function stretchOf({ line, end }, [from, to]) {
  const isAmong = (/** @type {number} */ one) => from <= one && one <= to
  const first = line.findIndex(isAmong)
  if (first < 0) return undefined
  const after = line.subarray(first).findIndex((one) => !isAmong(one))
  return [first > 0 ? end[first - 1] : 0, end[(after < 0 ? line.length : first + after) - 1]]
}

/** @param {Cause} cause @param {(lines: [number, number]) => void} show */
function causeOf({ name, sentence, told, lines, confidence, sections, vendors, indistinguishable_from: others, position_mm: form }, show) {
  /** @type {(string | Node)[][]} */
  const rows = told.map(({ name, value, deviation, unit }) => [name, worded(`${value}${deviation === null ? '' : ` ± ${deviation}`} ${unit}`.trim())])
  if (lines.length > 0) rows.push([say.common.lines, linesOf(lines, show)])
  if (form !== null) rows.push([say.diagnosis.formError, errorLabel(form)])
  if (confidence !== null) {
    const proof = sections ? say.diagnosis.proof(sections[0], sections[0] + sections[1]) : ''
    rows.push([say.diagnosis.howSure, `${Math.round(100 * confidence)} %${proof}`])
  }
  rows.push([say.diagnosis.elseItCouldBe, others.length > 0 ? others.map(spoken).join(', ') : say.diagnosis.nothingElse])
  if (vendors) rows.push([say.diagnosis.setting, vendors])
  const list = rows.map(([term, text]) => make('div', {}, make('dt', {}, term), make('dd', {}, text)))
  return make('article', { className: 'cause' }, make('h3', {}, name), make('p', {}, worded(sentence)), make('dl', {}, ...list))
}

/** Where a cause acts: each place behind a click, all of them behind one. @param {[number, number][]} lines @param {(lines: [number, number]) => void} show */
function linesOf(lines, show) {
  const place = (/** @type {[number, number]} */ one) => {
    const go = make('button', { type: 'button', title: say.common.showInCharts }, range(one))
    go.addEventListener('click', () => show(one))
    return go
  }
  if (lines.length === 1) return place(lines[0])
  const all = make('details', { className: 'lines' }, make('summary', {}, say.diagnosis.places(count(lines.length))))
  // Of hundreds nobody needs the buttons before they are asked for.
  all.addEventListener('toggle', () => all.childElementCount === 1 && all.append(...lines.map(place)))
  return all
}

/** The account as a table with a bar a row; nothing of a diagnosis that was kept before there was one. @param {DiagnosisReport} report */
function accountOf({ account }) {
  if (!account) return []
  const rows = account.steps.map(({ name, text, kind, bar: [from, to] }) => {
    const bar = make('i', { className: `is-${kind}` })
    Object.assign(bar.style, { left: `${100 * from}%`, width: `${100 * (to - from)}%` })
    const place = make('td', { className: 'bar' }, bar)
    place.setAttribute('aria-hidden', 'true')
    return make('tr', {}, make('th', { scope: 'row' }, name), make('td', { className: 'seconds' }, worded(text)), place)
  })
  const all = make('table', { className: account.begins_s ? 'account broken' : 'account' }, make('caption', {}, say.diagnosis.account), make('tbody', {}, ...rows))
  return [all, make('p', { className: 'facts' }, worded(account.notes.join(' ')))]
}

/** @param {string} caption @param {string[]} titles @param {(string | Node)[][]} rows */
function table(caption, titles, rows) {
  const head = make('tr', {}, ...titles.map((title) => (title ? make('th', { scope: 'col' }, title) : make('td', {}))))
  const body = rows.map(([name, ...cells]) => make('tr', {}, make('th', { scope: 'row' }, name), ...cells.map((cell) => make('td', {}, cell))))
  const all = make('table', {}, make('caption', {}, caption), make('thead', {}, head), make('tbody', {}, ...body))
  return scroll(all)
}

/** @param {DiagnosisReport} report */
function numbersTable({ fit }) {
  /** @type {[string, Sides, (value: number) => string][]} */
  const all = [
    [say.diagnosis.cycleTimeError, fit.cycle_time_error_s, difference],
    [say.diagnosis.feedRmse, fit.feed_rmse_mm_min, feedrate],
    [say.diagnosis.feedRmseHeldOut, fit.held_out.feed_rmse_mm_min, feedrate],
    [say.diagnosis.positionRmse, fit.position_rmse_mm, errorLabel],
  ]
  const rows = all.flatMap(([name, { before, after }, written]) => (before === null || after === null ? [] : [[name, written(before), written(after)]]))
  return table(say.diagnosis.beforeAfter, ['', say.common.before, say.diagnosis.after], rows)
}

/** @param {DiagnosisReport} report @param {string[]} names @param {(run: number, distances: [number, number]) => void} show */
function regionsTable({ regions }, names, show) {
  const all = regions.reduce((sum, { seconds: own }) => sum + Math.abs(own), 0)
  const rows = regions.map(({ lines, seconds: own, distance_mm: distances, time_s: times, run }) => {
    const go = make('button', { type: 'button', title: say.common.showInCharts }, range(lines))
    go.addEventListener('click', () => show(run, distances))
    const share = `${Math.round((100 * Math.abs(own)) / all)} %`
    const when = `${seconds(times[0])} – ${seconds(times[1])}`
    return [go, lostLabel(own), share, when, ...(names.length > 1 ? [names[run]] : [])]
  })
  const titles = [say.common.lines, say.common.lost, say.diagnosis.share, say.diagnosis.recordedAt, ...(names.length > 1 ? [say.common.recording] : [])]
  if (rows.length === 0) return make('p', { className: 'facts' }, say.diagnosis.nowhere)
  return table(say.diagnosis.whereTheyDiffer, titles, rows)
}

/** @param {DiagnosisReport} report */
function notShown({ not_excited: ids }) {
  if (ids.length === 0) return []
  const text = ids.map(spoken).join(', ')
  return [make('p', { className: 'facts not-excited' }, say.diagnosis.notExcited(text))]
}
