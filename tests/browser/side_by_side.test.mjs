// A long program is simulated by several workers side by side: what the page shows is what one worker would say.

import assert from 'node:assert/strict'
import { computed, cycleTimes, longTest, pageTest, shot, workersEnded } from './steps.mjs'

/** Lines enough for several workers. */
const LONG = 90_000

/** A program of short blocks. */
function program(blocks) {
  const lines = ['G21 G90 G94', 'G0 X0 Y0 Z0', 'F3000']
  for (let i = 1; i <= blocks; i += 1) lines.push(`G1 X${(i * 0.1).toFixed(3)} Y${(Math.sin(i) * 0.2).toFixed(3)}`)
  return { name: 'long.nc', mimeType: 'text/plain', buffer: Buffer.from(lines.join('\n')) }
}

/** From now on the machine has so many cores. */
const cores = (page, count) => page.evaluate((count) => Object.defineProperty(navigator, 'hardwareConcurrency', { value: count, configurable: true }), count)

/** Counts workers beside the first that are started and ended, and notes where they are from. Those that are `mortal` die at work. */
const count = (page, { mortal = false } = {}) =>
  page.evaluate((mortal) => {
    window.further = { started: 0, ended: 0 }
    window.addresses = new Set()
    window.Worker = class extends window.Worker {
      constructor(address, options) {
        super(address, options)
        window.addresses.add(new URL(address).protocol)
      }
      postMessage(message) {
        super.postMessage(message)
        if (!message.request?.runsOnly) return
        window.further.started += 1
        this.addEventListener('message', ({ data }) => {
          if (mortal && data.name) this.onerror(new ErrorEvent('error', { message: 'out of memory' }))
        })
        this.terminate = () => {
          window.further.ended += 1
          super.terminate()
        }
      }
    }
  }, mortal)

/** Cycle times of the long program. */
async function timesOf(page) {
  await page.setInputFiles('#files', program(LONG))
  await computed(page)
  return cycleTimes(page)
}

/** Notes where the bar stands and what is said beside it. */
const watch = (page) =>
  page.evaluate(() => {
    const root = document.querySelector('#progress')
    window.said = []
    const note = () => !root.hidden && window.said.push([root.querySelector('progress').value, root.querySelector('p').textContent])
    new MutationObserver(note).observe(root, { attributes: true, childList: true, subtree: true })
  })

longTest('two workers say what one does, the bar never goes back, and the second one ends', async ({ page }) => {
  await count(page)
  await cores(page, 1)
  const times = await timesOf(page)
  assert.equal(await page.evaluate(() => window.further.started), 0)
  await page.click('#program .remove')
  await cores(page, 2)
  await watch(page)
  await page.setInputFiles('#files', program(LONG))
  await page.waitForFunction(() => document.querySelector('#progress p').textContent.includes(', '))
  await shot(page, 'side-by-side-at-work')
  await computed(page)
  await shot(page, 'side-by-side-done')
  assert.deepEqual(await cycleTimes(page), times)
  assert.deepEqual(await page.evaluate(() => window.further), { started: 1, ended: 1 })
  // One from a blob is under the policy of the page (confined.js).
  assert.deepEqual(await page.evaluate(() => [...window.addresses]), ['blob:'])
  const said = await page.evaluate(() => window.said)
  const parts = said.map(([part]) => part)
  assert.deepEqual(
    parts,
    [...parts].sort((a, b) => a - b),
  )
  assert.ok(
    said.some(([, text]) => /Simulating .+, .+/.test(text)),
    'it says what both are at',
  )
})

pageTest('runs are bit for bit the same whoever computes them, and lost with nobody', async ({ page }) => {
  const text = program(20_000).buffer.toString()
  const compared = await page.evaluate(async (text) => {
    const [{ Engine }, { confinedWorker }, { wholeModule }, { simulate }] = await Promise.all(['engine', 'confined', 'module', 'side_by_side'].map((name) => import(`/${name}.js`)))
    const { form } = await import('/pkg/truefeed.js')
    const columns = [null, 0.005, 0.01, 0.02, 0.05]
    const request = { program: new Blob([text]), machine: JSON.stringify(JSON.parse(form()).presets[0].values), dialect: null, columns, labels: columns.map(String) }
    /** All that is heard of a request, as text with every digit. */
    const heard = async (engine, work) => {
      const all = { programs: 0, runs: {}, parts: [] }
      await work(engine, request, {
        stage: (_, part) => all.parts.push(part),
        program: () => (all.programs += 1),
        run: (column, run) => (all.runs[column] = JSON.stringify(run, (_, value) => (ArrayBuffer.isView(value) ? [...value] : value))),
      })
      engine.end()
      return all
    }
    Object.defineProperty(navigator, 'hardwareConcurrency', { value: 3 })
    const compiled = await wholeModule()
    /** An engine whose first worker dies at work, or which gets no second one. */
    const engineWhere = ({ firstDies = false, isAlone = false }) => {
      let started = 0
      return new Engine(compiled, () => {
        if (isAlone && started > 0) throw new Error('no more of them')
        const worker = confinedWorker()
        const isFirst = started++ === 0
        worker.addEventListener('message', ({ data }) => {
          if (firstDies && isFirst && data.name) worker.onerror(new ErrorEvent('error', { message: 'out of memory' }))
        })
        return worker
      })
    }
    const one = await heard(engineWhere({}), (engine, ...rest) => engine.simulate(...rest))
    const several = []
    for (const fate of [{}, { isAlone: true }, { firstDies: true }]) several.push(await heard(engineWhere(fate), simulate))
    return several.map(({ programs, runs, parts }) => ({
      programs,
      columns: Object.keys(runs).length,
      isSame: Object.keys(one.runs).every((column) => one.runs[column] === runs[column]),
      isForward: parts.every((part, index) => index === 0 || parts[index - 1] <= part),
    }))
  }, text)
  for (const said of compared) assert.deepEqual(said, { programs: 1, columns: 4, isSame: true, isForward: true })
})

longTest('cancelling ends all workers, and the next run has all results', async ({ page }) => {
  await count(page)
  await cores(page, 2)
  await page.setInputFiles('#files', program(4 * LONG))
  await page.waitForFunction(() => document.querySelector('#progress p').textContent.includes(', '))
  await page.click('#progress button')
  await page.waitForFunction(() => document.querySelector('#progress p').textContent.startsWith('Cancelled'))
  assert.deepEqual(await page.evaluate(() => window.further), { started: 1, ended: 1 })
  await workersEnded(page)
  await page.click('#progress button')
  await computed(page)
  assert.ok((await cycleTimes(page)).every((time) => time > 0))
})

longTest('a further worker that dies loses nothing', async ({ page }) => {
  await cores(page, 1)
  const times = await timesOf(page)
  await page.click('#program .remove')
  await count(page, { mortal: true })
  await cores(page, 2)
  assert.deepEqual(await timesOf(page), times)
  assert.ok(await page.isHidden('#failure'))
  assert.deepEqual(await page.evaluate(() => window.further), { started: 1, ended: 1 })
})

longTest('a short program starts no second worker', async ({ page }) => {
  await count(page)
  await cores(page, 8)
  await page.setInputFiles('#files', program(2000))
  await computed(page)
  assert.equal(await page.evaluate(() => window.further.started), 0)
})
