// Simulates, compares, calibrates and diagnoses in the background: one request in, messages out, columns transferred.

/** @import { StageName } from "./texts.js" */
/** @import { CalibrateRequest, CompareRequest, CutRequest, PairRequest, QuoteRequest, ReviseRequest, SimulateRequest, TimesOverRequest, TimesRequest } from "./engine.js" */

/** The functions of the module that is here, which all requests to one worker have. @type {typeof import("./pkg/truefeed_whole.js")} */
let glue

const VERBS = { simulate, pair, compare, revise, calibrate, diagnose, cycleTimes, timesOver, cut, quote }
const CURVE = /** @type {const} */ (['distance', 'feedrate', 'time', 'corner', 'arcs', 'alongArcs', 'paceEnd', 'paceFeedrate'])
const MATCHED = /** @type {const} */ (['recordedDistance', 'recordedFeedrate', 'recordedTime', 'simulatedDistance', 'simulatedFeedrate', 'simulatedTime', 'lostDistance', 'lostSeconds'])

const DIAGNOSED = /** @type {const} */ (['end', 'feedrate', 'rapid', 'line', 'distances', 'feedrates', 'times', 'lostDistances', 'lostSeconds'])

const LOADS = /** @type {const} */ (['distance', 'programmedForce', 'predictedForce', 'programmedPower', 'predictedPower', 'programmedRate', 'predictedRate', 'predictedPerTooth'])

/** @type {Promise<void> | undefined} */
let ready

/** What comes without a verb is only there to be ready. */
self.onmessage = async ({ data: { module, isWhole, language, verb, request } }) => {
  try {
    ready ??= begin(module, isWhole, language)
    await ready
    if (verb === undefined) return
    await VERBS[/** @type {keyof typeof VERBS} */ (verb)](request)
    post({ type: 'done' }, [])
  } catch (error) {
    const message = error instanceof Error ? error.message : String(error)
    post({ type: 'failure', message, bug: error instanceof WebAssembly.RuntimeError, left: error instanceof Left }, [])
  }
}

/** @param {WebAssembly.Module} module @param {boolean} isWhole @param {string} language  in which the page writes numbers */
async function begin(module, isWhole, language) {
  // What the first module leaves out is asked of the whole alone (engine.js).
  const script = isWhole ? import('./pkg/truefeed_whole.js') : import('./pkg/truefeed.js')
  glue = /** @type {typeof glue} */ (await script)
  await glue.default({ module_or_path: module })
  // The pictures of reports are drawn here.
  if (isWhole) glue.setNumbers((await import('./format.js')).axisIn(language))
}

/** @param {SimulateRequest} request */
async function simulate({ program, machine, dialect, columns, labels, runsOnly }) {
  const of = columns.length + 1
  stage('readingProgram', 0, of)
  const job = await jobOf(program, machine, dialect)
  const held = job.tolerances()
  if (!runsOnly) {
    const steps = plain(job.steps(), ['end', 'feedrate', 'rapid', 'line'])
    const trail = plain(job.trail(), ['points', 'distance'])
    const columnsOfProgram = [...Object.values(steps), ...Object.values(trail)]
    post({ type: 'program', summary: job.summary(), steps, trail, held }, columnsOfProgram)
  }
  for (const [index, column] of columns.entries()) {
    if (column === null && held.length === 0) continue
    const progress = (/** @type {number} */ part) => stage('simulating', index + 1 + part, of, labels[index])
    progress(0)
    const run = job.simulate(column ?? undefined, progress)
    const curve = plain(run.columns, [...CURVE])
    const { runs, trust } = run.summary
    post({ type: 'run', column, summary: { ...runs[0], trust }, columns: curve, note: run.note, placesInInches: run.placesInInches }, Object.values(curve))
    run.free()
  }
  job.free()
}

/** @param {PairRequest} request */
async function pair({ machine, programs, recording: { name, bytes, interval } }) {
  const candidates = new glue.Candidates(machine)
  for (const [index, { program, dialect }] of programs.entries()) {
    stage('pairing', index, programs.length + 1, name)
    candidates.add(await bytesOf(program), dialect ?? undefined)
  }
  stage('pairing', programs.length, programs.length + 1, name)
  const found = [...candidates.of(bytes, interval ?? undefined)]
  candidates.free()
  post({ type: 'paired', found }, [])
}

/** @param {ReviseRequest} sides */
async function revise(sides) {
  const [first, second] = await Promise.all(sides.map(({ program }) => textOf(program)))
  const asked = sides.map(({ machine, dialect, tolerance }) => ({ machine, dialect, tolerance }))
  const { report, columns } = glue.compareRevisions(first, second, JSON.stringify(asked))
  const curve = plain(columns, ['distance', 'later'])
  post({ type: 'revised', report, columns: curve }, Object.values(curve))
}

/** @param {CompareRequest} request */
async function compare({ program, machine, dialect, recording, interval }) {
  const { report, refusal, columns } = glue.compareRecording(await bytesOf(program), machine, dialect ?? undefined, recording, interval ?? undefined)
  const curves = plain(columns, [...MATCHED])
  post({ type: 'compared', report, refusal, columns: curves }, Object.values(curves))
}

/** @param {CutRequest} request */
async function cut({ program, machine, dialect, tolerance, job }) {
  const progress = (/** @type {number} */ part) => stage('forces', part, 1)
  progress(0)
  const { summary, columns } = glue.computeCutting(await bytesOf(program), machine, dialect ?? undefined, tolerance ?? undefined, job, progress)
  const loads = plain(columns, [...LOADS])
  post({ type: 'cut', summary, columns: loads }, Object.values(loads))
}

/** @param {QuoteRequest} request */
async function quote({ program, request, picture }) {
  const text = await textOf(program)
  try {
    const quote = glue.quoteText(text, request, (/** @type {number} */ part) => stage('simulating', part, 1))
    post(
      {
        type: 'quoted',
        quote,
        labels: quote.runs.map((/** @type {any} */ run) => glue.toleranceLabel(run.tolerance_mm)),
        picture: picture ? await pathOf(program, quote.dialect, picture) : undefined,
      },
      [],
    )
  } catch (refusal) {
    // A refused request leaves the worker as it is; anything else is a fault of it.
    if (typeof refusal !== 'string') throw refusal
    post({ type: 'quoted', refusal: JSON.parse(refusal), labels: [] }, [])
  }
}

/** The path of a program as SVG, which is the same on any machine. @param {SimulateRequest["program"]} program @param {string} dialect @param {number[]} size  CSS pixels */
async function pathOf(program, dialect, [width, height]) {
  const [{ values }] = JSON.parse(glue.form()).presets
  const job = await jobOf(program, JSON.stringify(values), dialect)
  const { end, feedrate, rapid, line } = plain(job.steps(), ['end', 'feedrate', 'rapid', 'line'])
  const { points, distance } = plain(job.trail(), ['points', 'distance'])
  job.free()
  const view = new glue.PathView()
  view.program(points, distance, end, feedrate, rapid, line)
  view.resize(width, height)
  // What is fitted is what is coloured.
  view.color('feedrate')
  view.look(view.isDeep() ? 'turned' : 'top')
  const { ends, unit } = view.legend()
  const [length] = view.scale()
  const svg = view.svg(`${Math.round(ends[0])} ${unit}`, `${Math.round(ends[1])} ${unit}`, `${Number(length.toPrecision(3))} mm`)
  view.free()
  return svg
}

/** @param {CalibrateRequest} request */
async function calibrate({ machine, runs }) {
  const of = runs.length + 10
  const all = await collected(machine, runs, of)
  const progress = (/** @type {number} */ part) => stage('calibrating', runs.length + 10 * part, of)
  progress(0)
  post({ type: 'calibrated', report: all.calibrate(progress) }, [])
  all.free()
}

/** @param {CalibrateRequest} request */
async function diagnose({ machine, runs }) {
  const of = runs.length + 10
  const all = await collected(machine, runs, of)
  const progress = (/** @type {number} */ part) => stage(stageAt(part), runs.length + 10 * part, of)
  progress(0)
  const found = all.diagnose(progress)
  all.free()
  if (!found) return post({ type: 'diagnosed', runs: [] }, [])
  const { report, json, html } = found
  const columns = found.runs.map((run) => plain(run, [...DIAGNOSED]))
  found.free()
  post(
    { type: 'diagnosed', report, json, html, runs: columns },
    columns.flatMap((own) => Object.values(own).flat()),
  )
}

/** What a diagnosis is at. @param {number} part */
const stageAt = (part) => (part < 1 ? 'trying' : 'testing')

/** @param {TimesRequest} request */
async function cycleTimes({ program, dialect, machines }) {
  const bytes = await bytesOf(program)
  post({ type: 'times', times: machines.map((machine) => glue.cycleTime(bytes, machine, dialect ?? undefined)) }, [])
}

/** @param {TimesOverRequest} request */
async function timesOver({ program, machine, dialect, columns }) {
  const job = await jobOf(program, machine, dialect)
  for (const column of columns) post({ type: 'time', column, time: job.cycleTime(column ?? undefined) }, [])
  job.free()
}

/** What the module here leaves to the whole one. */
class Left extends Error {}

/** A program on a machine. @param {SimulateRequest["program"]} program @param {string} machine @param {string | null} dialect */
async function jobOf(program, machine, dialect) {
  const job = glue.Job.of(await textOf(program), machine, dialect ?? undefined)
  if (!job) throw new Left()
  return job
}

/** All runs of a machine, read. @param {string} machine @param {CalibrateRequest["runs"]} runs @param {number} of */
async function collected(machine, runs, of) {
  const all = new glue.Runs(machine)
  for (const [index, { name, program, dialect, recording, interval }] of runs.entries()) {
    stage('reading', index, of, name)
    all.add(name, await bytesOf(program), dialect ?? undefined, recording, interval ?? undefined)
  }
  return all
}

/** The text of a program in the memory of the module, where a file goes piece by piece. @param {Blob | Uint8Array} program */
async function textOf(program) {
  const file = program instanceof Blob ? program : new Blob([/** @type {Uint8Array<ArrayBuffer>} */ (program)])
  const text = new glue.ProgramText(file.size)
  const reader = file.stream().getReader()
  for (let piece = await reader.read(); piece.value; piece = await reader.read()) text.push(piece.value)
  return text
}

/** @param {Blob | Uint8Array} program */
async function bytesOf(program) {
  return program instanceof Blob ? new Uint8Array(await program.arrayBuffer()) : program
}

/** Says what it is at; the words are the page's. @param {StageName} stage @param {number} done @param {number} of @param {string} [name] */
function stage(stage, done, of, name) {
  post({ type: 'stage', stage, part: done / of, name }, [])
}

/**
 * The named columns of a handle of the module as a plain object; the handle is given back.
 * @template {{free(): void}} H
 * @template {keyof H} K
 * @param {H} handle
 * @param {K[]} names
 * @returns {Pick<H, K>}
 */
function plain(handle, names) {
  const columns = /** @type {Pick<H, K>} */ (Object.fromEntries(names.map((name) => [name, handle[name]])))
  handle.free()
  return columns
}

/** @param {object} message @param {ArrayBufferView[]} columns */
function post(message, columns) {
  self.postMessage(message, { transfer: columns.map((column) => column.buffer) })
}
