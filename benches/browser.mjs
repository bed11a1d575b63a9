// How fast and how large the WebAssembly module is in Chromium, beside the native program on the same machine:
//
//   scripts/build && node benches/browser.mjs [MEGABYTES] [--native] [--chart]
//
// Makes a wavy finishing pass (benches/speed/programs.rs) of that size in the page, 300 MB by default, as a file of
// pieces, and has the page's worker quote it for one tolerance: it is streamed into the module's memory and is never
// whole in JavaScript. With --native the native program does the same for one of the same number of lines, quote and
// columns of the charts (cargo bench --bench speed, "chart"), and the ratio is printed. Times are what the processor worked, not what passed: other work on the machine does not count.
//
// With --chart it also draws the chart of four tolerances on a canvas of 1920 pixels, from the whole path to a millionth of
// it, with one device pixel to each of the page's and with four (devicePixelRatio 2), and prints how long the slowest zoom takes;
// and it turns the path in space, as a user does by dragging, and prints how long the slowest picture takes.

import { execFileSync } from 'node:child_process'
import { existsSync, readFileSync } from 'node:fs'
import { argv } from 'node:process'
import { openPage } from '../tests/browser/harness.mjs'

if (existsSync(new URL('../www/pkg/quick-build', import.meta.url))) throw new Error('www/pkg is a quick build, which is slower; run scripts/build')
const megabytes = Number(argv.slice(2).find((argument) => /^\d+$/.test(argument)) ?? 300)

const { page, close } = await openPage({ path: '/index.html' })
try {
  const browser = /** @type {import('playwright-core').Browser} */ (page.context().browser())
  const system = await browser.newBrowserCDPSession()
  /** The process of the page: seconds it worked, and its number. */
  const renderer = async () => {
    const { processInfo } = await system.send('SystemInfo.getProcessInfo')
    return processInfo.filter(({ type }) => type === 'renderer').reduce((a, b) => (a.cpuTime < b.cpuTime ? b : a))
  }
  const { lines, bytes } = await page.evaluate(make, megabytes * 1e6)
  const before = await renderer()
  const { cycleTime, seconds } = await page.evaluate(quoted)
  const { cpuTime, id } = await renderer()
  const worked = cpuTime - before.cpuTime
  const peak = Number(/VmHWM:\s*(\d+)/.exec(readFileSync(`/proc/${id}/status`, 'utf8'))?.[1]) * 1024
  console.log(`${lines} lines, ${(bytes / 1e6).toFixed(0)} MB, cycle time ${cycleTime.toFixed(1)} s`)
  console.log(`Chromium: worked ${worked.toFixed(1)} s (${seconds.toFixed(1)} s passed), peak of the page ${(peak / bytes).toFixed(1)} × the file`)
  if (argv.includes('--chart')) {
    for (const { ratio, slowest, zoom } of await page.evaluate(drawn))
      console.log(`chart of four tolerances, 1920 pixels wide, devicePixelRatio ${ratio}: ${slowest.toFixed(1)} ms at the slowest zoom, ${zoom}-fold`)
    console.log(`path in space, 1280 × 720 pixels: ${(await page.evaluate(turned)).toFixed(1)} ms for the slowest picture while it turns`)
  }
  if (argv.includes('--native')) {
    const command = ['bench', '--locked', '--bench', 'speed', '--', 'measure', 'chart', 'finishing', String(lines)]
    const [time, native] = execFileSync('cargo', command, { encoding: 'utf8' }).trim().split(' ').map(Number)
    console.log(`native: worked ${time.toFixed(1)} s, peak ${(native / bytes).toFixed(1)} × the file`)
    console.log(`WebAssembly over native: ${(worked / time).toFixed(2)}`)
  }
} finally {
  await close()
}

/** Runs in the page: makes the program. @param {number} size bytes */
function make(size) {
  const pieces = []
  let [bytes, lines, x, y, forward, feedrate] = [0, 0, 0, 0, true, 3000]
  let text = 'G90 G17 G21 G91.1\nS12000 M3\nG0 X0 Y0 Z5\n'
  while (bytes < size) {
    while (text.length < 1e6) {
      const step = 0.3 + 0.18 * Math.sin(0.7 * lines)
      x += forward ? step : -step
      if (x < 0 || 60 < x) {
        x = Math.min(Math.max(x, 0), 60)
        y += 0.4
        forward = !forward
        feedrate = 3000 + ((feedrate - 3000 + 1700) % 5001)
      }
      const z = 1.5 * Math.sin(0.31 * x) * Math.cos(0.17 * y) + 0.2 * Math.sin(1.9 * x)
      text += `G1 X${x.toFixed(3)} Y${y.toFixed(3)} Z${z.toFixed(3)} F${feedrate}\n`
      lines += 1
    }
    // A Blob keeps what it is given outside the memory of JavaScript.
    pieces.push(new Blob([text]))
    bytes += text.length
    text = ''
  }
  Object.assign(window, { made: new Blob([...pieces, 'G0 Z5\nM30\n']) })
  return { lines, bytes }
}

/** Runs in the page: quotes it. */
async function quoted() {
  /** @type {any} */
  const { Engine } = await import(/** @type {any} */ ('/engine.js'))
  const module = { module: await WebAssembly.compileStreaming(fetch('/pkg/truefeed_whole_bg.wasm')), isWhole: true }
  // What the native program takes where nothing is given.
  const machine = { 'interpolator.filters': 3, 'interpolator.time_constant_s': 0.0255, 'rapid.feed_mm_min': 12000 }
  Object.assign(window, { engine: new Engine(module), machine })
  const request = JSON.stringify({ machine, tolerances: [0.01], name: '' })
  const begin = performance.now()
  const { quote, refusal } = await /** @type {any} */ (window).engine.quote({ program: /** @type {any} */ (window).made, request }, () => {})
  if (!quote) throw new Error(JSON.stringify(refusal))
  return { cycleTime: quote.runs[0].cycle_time_s, seconds: (performance.now() - begin) / 1000 }
}

/** Runs in the page: draws its chart at every zoom; the least of three times counts, as other work on the machine does not. */
async function drawn() {
  const { engine, made: program, machine } = /** @type {any} */ (window)
  /** @type {any} */
  const whole = await import(/** @type {any} */ ('/pkg/truefeed_whole.js'))
  await whole.default({ module_or_path: '/pkg/truefeed_whole_bg.wasm' })
  const chart = new whole.Chart()
  const columns = [0.005, 0.01, 0.02, 0.05]
  const request = { program, machine: JSON.stringify(machine), dialect: null, columns, labels: columns.map((mm) => `${mm} mm`) }
  await engine.simulate(request, {
    stage() {},
    /** @param {any} _ @param {any} steps */
    program: (_, { end, feedrate, rapid, line }) => chart.program(end, feedrate, rapid, line),
    /** @param {number} tolerance @param {any} run */
    run(tolerance, { columns: { distance, feedrate, time, corner, arcs, alongArcs } }) {
      const [from, to, within] = [0, Infinity, tolerance].map((value) => Float64Array.of(value))
      chart.add(`${tolerance} mm`, from, to, within)
      chart.fill(distance, feedrate, time)
      chart.fillErrors(corner, arcs, alongArcs)
    },
  })
  const canvas = document.createElement('canvas')
  return [1, 2].map((ratio) => {
    chart.fit(true)
    const time = () => {
      const begin = performance.now()
      chart.draw(canvas, 1920, 600, ratio)
      return performance.now() - begin
    }
    let [slowest, zoom] = [0, 1]
    for (let part = 0; part <= 20; part += 1) {
      const least = Math.min(time(), time(), time())
      if (slowest < least) [slowest, zoom] = [least, 2 ** part]
      chart.zoom(2)
    }
    return { ratio, slowest, zoom }
  })
}

/** Runs in the page: draws its path in space from around it; the least of three times counts. */
async function turned() {
  const { engine, made: program, machine } = /** @type {any} */ (window)
  /** @type {any} */
  const whole = await import(/** @type {any} */ ('/pkg/truefeed_whole.js'))
  const view = new whole.PathView()
  const request = { program, machine: JSON.stringify(machine), dialect: null, columns: [0.01], labels: ['0.01 mm'] }
  await engine.simulate(request, {
    stage() {},
    /** @param {any} _ @param {any} steps @param {any} _held @param {any} trail */
    program: (_, { end, feedrate, rapid, line }, _held, trail) => view.program(trail.points, trail.distance, end, feedrate, rapid, line),
    run() {},
  })
  const canvas = document.createElement('canvas')
  view.resize(1280, 720)
  view.look('turned')
  const time = () => {
    view.turn(0.12, 0.03)
    const begin = performance.now()
    view.draw(canvas, 1280, 720, 1)
    return performance.now() - begin
  }
  let slowest = 0
  for (let part = 0; part < 20; part += 1) slowest = Math.max(slowest, Math.min(time(), time(), time()))
  return slowest
}
