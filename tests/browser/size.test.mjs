// The delivered page computes what www/ computes. The full suite also checks how many bytes it sends with brotli: up to the first
// chart of a first visit, and in all.

import assert from 'node:assert/strict'
import { execFileSync } from 'node:child_process'
import { existsSync, mkdtempSync, readdirSync, rmSync, statSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after, before, test } from 'node:test'
import { openPage } from './harness.mjs'
import { ROOT, computed, cycleTimes, longPlainTest } from './steps.mjs'

const MOST_BYTES = 400_000
/** More than the 1.35 MB that we want. Compiled for size, the whole module would be 4 % smaller, and a calibration take half as long again. */
const MOST_BYTES_EVER = 1_530_000
const WHOLE = '/pkg/truefeed_whole_bg.wasm'
/** What no visit of the page loads: what other pages embed, licences, the worker that keeps files, and of the picture of the answer all but the one for the screen. */
const NOT_LOADED = /^embed|notices\.txt$|^sw\.js|\.br$|answer-(phone|dark)/

const delivered = mkdtempSync(join(tmpdir(), 'truefeed-delivered-'))
before(() => execFileSync('node', [join(ROOT, 'scripts/bundle.mjs'), delivered], { stdio: 'ignore' }))
after(() => rmSync(delivered, { recursive: true }))

/** What came over the wire for a request, and when it began. @param {import('playwright-core').Request} request */
async function weighed(request) {
  const { responseBodySize, responseHeadersSize } = await request.sizes()
  const { startTime: start } = request.timing()
  return { path: new URL(request.url()).pathname, start, bytes: responseBodySize + responseHeadersSize }
}

const kB = (/** @type {number} */ bytes) => `${Math.ceil(bytes / 1000)} kB`

/** Visits the delivered page for the first time. Returns what the browser received, and when it had drawn a chart. */
async function visited() {
  const { page, origin, errors, close } = await openPage({ path: '/icon.svg', folder: delivered })
  try {
    // What the service worker fetches beside the visit, to keep it, is not among them.
    /** @type {Promise<{path: string, start: number, bytes: number}>[]} */
    const coming = []
    const note = (/** @type {import('playwright-core').Request} */ request) => coming.push(weighed(request))
    page.on('requestfinished', note)
    await page.goto(`${origin}/`)
    await page.waitForSelector('html[data-ready]')
    // Notes when the first time of the table and a chart were there: the one or the other comes last.
    await page.evaluate(() => {
      const notes = new MutationObserver(() => {
        const canvas = document.querySelector('#chart canvas')
        if (!document.querySelector('#tolerances data') || !canvas.width || !canvas.height) return
        const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height)
        if (!data.some((value) => value !== 0)) return
        notes.disconnect()
        window.firstChart = performance.timeOrigin + performance.now()
      })
      notes.observe(document.querySelector('#results'), { childList: true, subtree: true })
      notes.observe(document.querySelector('#chart .plot'), { attributes: true })
    })
    await page.click('#welcome .sample')
    await computed(page)
    await page.waitForSelector('html[data-whole]')
    await page.waitForLoadState('networkidle')
    // The page may fetch on until it is closed, when no request can be asked any more.
    page.off('requestfinished', note)
    const received = await Promise.all(coming)
    const at = await page.evaluate(() => window.firstChart)
    return { at, first: received.filter(({ start }) => start <= at), later: received.filter(({ start }) => at < start), times: await cycleTimes(page), errors }
  } finally {
    await close()
  }
}

/** @type {ReturnType<typeof visited> | undefined} */
let visit
/** The one visit that all tests look at. */
const firstVisit = () => (visit ??= visited())

/** Fails on a quick build, which is larger than the delivered one. */
const assertDelivered = () => assert.ok(!existsSync(join(ROOT, 'www/pkg/quick-build')), 'www/pkg is a quick build; run scripts/build')

const sumOf = (/** @type {{ bytes: number }[]} */ all) => all.reduce((sum, { bytes }) => sum + bytes, 0)

test('the delivered page computes the sample, and loads its whole module after the first chart', { timeout: 180_000 }, async () => {
  const { at, first, later, times, errors } = await firstVisit()
  assert.ok(at, 'no chart is drawn')
  assert.equal(times.length, 3)
  for (const path of ['/main.js', '/worker.js', '/pkg/truefeed_bg.wasm', '/samples/pocket.nc'])
    assert.ok(
      first.some((one) => one.path === path),
      `${path} is not counted`,
    )
  assert.ok(
    later.some(({ path }) => path === WHOLE),
    'the whole module does not come after the first chart',
  )
  assert.ok(!first.some(({ path }) => path === WHOLE), 'the whole module is fetched before the first chart is there')
  // A picture alone names no icon, so that the browser asks for the usual one.
  assert.deepEqual(
    errors.filter((error) => !error.includes('/favicon.ico')),
    [],
  )
})

longPlainTest('a first visit is small up to its charts', { timeout: 180_000 }, async (context) => {
  assertDelivered()
  const { first, later } = await firstVisit()
  const module = sumOf(first.filter(({ path }) => path === '/pkg/truefeed_bg.wasm'))
  context.diagnostic(`a first visit takes ${kB(sumOf(first))} until its chart is there, ${kB(module)} of them its module; ${kB(sumOf(later))} come after`)
  assert.ok(sumOf(first) < MOST_BYTES, `a first visit takes ${sumOf(first)} bytes`)
})

longPlainTest('all that is ever loaded stays small', {}, (context) => {
  assertDelivered()
  const sent = readdirSync(delivered, { recursive: true })
    .map(String)
    .filter((name) => !NOT_LOADED.test(name) && statSync(join(delivered, name)).isFile())
    .map((name) => ({ name, bytes: statSync(join(delivered, name), { throwIfNoEntry: true }).size, small: statSync(join(delivered, `${name}.br`), { throwIfNoEntry: false })?.size }))
  const sum = sent.reduce((total, { bytes, small }) => total + (small ?? bytes), 0)
  context.diagnostic(`all ${sent.length} files of the page take ${kB(sum)}`)
  assert.ok(sent.some(({ name }) => name === 'pkg/truefeed_whole_bg.wasm') && sent.some(({ name }) => name === 'main.js'))
  assert.ok(sum <= MOST_BYTES_EVER, `all files take ${sum} bytes`)
})
