// Quotes embedded elsewhere: two components on one page, a frame under a portal of another origin, hostile messages, and the
// package in Node and in a bundle. All of them give the times of the command line.

import assert from 'node:assert/strict'
import { execFileSync, spawnSync } from 'node:child_process'
import { mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after, before, test } from 'node:test'
import { build } from 'vite'
import { servePlainPage, servePortal } from '../../examples/embedding/serve.mjs'
import { serve } from '../../scripts/serve.mjs'
import { leaving, openPage } from './harness.mjs'
import { binary, leftForAll, longPlainTest, ROOT, shot } from './steps.mjs'

const SAMPLE = join(ROOT, 'www/samples/pocket.nc')
const PACKAGE = join(ROOT, 'target/npm')
const MACHINE = 'Vertical machining centre, mid-range'

/** That machine as a file. */
const MACHINE_FILE = `name = "${MACHINE}"
[interpolator]
filters = 3
time_constant_s = 0.030
contour_tolerance_mm = 0.020
[rapid]
feed_mm_min = 24000
[times]
tool_change_s = 6
[rates]
hourly = 85
`

const scratch = mkdtempSync(join(tmpdir(), 'truefeed-embed-'))
after(() => rmSync(scratch, { recursive: true }))
before(() => execFileSync(join(ROOT, 'scripts/package'), ['--quick'], { stdio: 'ignore' }))

/** What the command line says. */
function predicted(program, tolerances) {
  const machine = join(scratch, 'machine.toml')
  writeFileSync(machine, MACHINE_FILE)
  const flags = tolerances.flatMap((tolerance) => ['--tolerance', String(tolerance)])
  const args = ['predict', program, '--machine', machine, ...flags, '--json']
  return JSON.parse(execFileSync(binary(), args, { encoding: 'utf8', maxBuffer: 1 << 28 }))
}

/** The two sides round differently in the last digit at most: they are two builds of one source. */
function assertAlike(quote, expected) {
  assert.equal(quote.runs.length, expected.runs.length)
  for (const [index, run] of quote.runs.entries()) {
    const { cycle_time_s: time, price } = expected.runs[index]
    assert.ok(time > 0 && Math.abs(run.cycle_time_s / time - 1) < 1e-9, `${run.cycle_time_s} instead of ${time}`)
    assert.ok(Math.abs(run.price - price) < 1e-6, `${run.price} instead of ${price}`)
  }
  assert.equal(quote.diagnostics.length, expected.diagnostics.length)
}

/** A page of an example, in a browser; its requests may go to the example's servers alone. `skip`: why it does not run */
function exampleTest(name, address, body, { skip = false } = {}) {
  test(name, { skip, timeout: 120_000 }, async (context) => {
    const [plain, portal] = await Promise.all([servePlainPage(), servePortal()])
    // Any page that is soon at rest: one that is left while it loads makes errors of its own.
    const opened = await openPage({ path: '/embed.html' })
    try {
      await opened.page.waitForLoadState('networkidle')
      await opened.page.goto(address({ plain, portal }))
      await body({ ...opened, plain, portal }, context)
      assert.deepEqual(opened.errors, [])
      const allowed = [plain.origin, portal.origin, opened.origin]
      const elsewhere = allowed.reduce((urls, origin) => leaving(urls, origin), opened.requests)
      assert.deepEqual(elsewhere, [])
    } finally {
      await Promise.all([opened.close(), plain.close(), portal.close()])
    }
  })
}

/** A test of an example that runs in the full suite only. */
const longExampleTest = (name, address, body) => exampleTest(name, address, body, { skip: leftForAll(name) })

const quoteOf = (page, id) => page.waitForFunction((id) => document.getElementById(id).quote, id, { timeout: 60_000 }).then((handle) => handle.jsonValue())
const rowsOf = (page, id) => page.$$eval(`#${id} tbody tr`, (rows) => rows.length)

exampleTest(
  'two components on one page, one by attributes and one by properties, each with its own program, machine and look',
  ({ plain }) => `${plain.origin}/page.html`,
  async ({ page }) => {
    const first = await quoteOf(page, 'first')
    assertAlike(first, predicted(SAMPLE, [0.01, 0.02, 0.05]))
    assert.equal(first.program, 'pocket.nc')
    assert.equal(await rowsOf(page, 'first'), 3)
    assert.equal(await page.$eval('#second', (element) => element.quote), null)

    // The answer is large, with its price in the currency and a picture of the path.
    const [own] = first.runs
    const headline = await page.textContent('#first .headline')
    assert.match(headline, /^\d:\d\d:\d\d €\d+\.\d\d per part at 10 µm$/)
    assert.ok(Math.abs(Number(/€([\d.]+)/.exec(headline)[1]) - own.price) < 0.006, `${headline} for ${own.price}`)
    assert.ok(await page.$eval('#first img', (picture) => picture.decode().then(() => picture.naturalWidth > 100)))
    // Several programs make a part: each of them, and their sum.
    await quoteOf(page, 'job')
    const quotes = await page.$eval('#job', (element) => element.quotes.map(({ program, runs }) => ({ program, time: runs[0].cycle_time_s })))
    assert.deepEqual(
      quotes.map(({ program }) => program),
      ['bracket-10.nc', 'bracket-20.nc', 'bracket-30.nc'],
    )
    const whole = Math.round(quotes.reduce((sum, { time }) => sum + time, 0))
    const [, minutes, seconds] = /^0:(\d\d):(\d\d)/.exec(await page.textContent('#job .headline'))
    assert.ok(Math.abs(60 * Number(minutes) + Number(seconds) - whole) <= 1)
    assert.equal(await page.$$eval('#job [part=programs] tbody tr', (rows) => rows.length), 3)

    await page.click('#write')
    const second = await quoteOf(page, 'second')
    assert.equal(second.program, 'zigzag.nc')
    assert.deepEqual(
      second.runs.map((run) => run.tolerance_mm),
      [0.05, 0.1],
    )
    assert.deepEqual((await quoteOf(page, 'first')).runs, first.runs)
    await page.waitForFunction(() => document.querySelector('#said').textContent.startsWith('zigzag.nc: '))

    const looks = await page.$$eval('truefeed-quote', (all) => all.map((one) => getComputedStyle(one).backgroundColor))
    assert.equal(looks[1], 'rgb(18, 53, 47)')
    assert.notEqual(looks[0], looks[1])
    for (const width of [1280, 360]) {
      await page.setViewportSize({ width, height: 760 })
      assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `it scrolls sideways at ${width}`)
      await shot(page, `embed-page-${width}`)
    }

    // The page's own style does not reach in, and its other tolerances are quoted anew.
    await page.$eval('#first', (element) => element.setAttribute('tolerances', 'programmed, 0.03'))
    await page.waitForFunction(() => document.querySelector('#first').quote?.runs.length === 2)
    const again = await quoteOf(page, 'first')
    assert.deepEqual(
      again.runs.map((run) => run.tolerance_mm),
      [0.02, 0.03],
    )
  },
)

exampleTest(
  'a component says what is wrong by an event, by a rejection and in sight, and goes on',
  ({ plain }) => `${plain.origin}/page.html`,
  async ({ page, errors }) => {
    await quoteOf(page, 'first')
    const kinds = await page.evaluate(async () => {
      const element = document.querySelector('#first')
      const heard = []
      element.addEventListener('error', ({ detail }) => heard.push(detail.kind))
      const tried = []
      const attempt = async (change) => {
        change()
        await element.compute().catch((error) => tried.push(error.kind))
      }
      const { machine } = element
      await attempt(() => (element.machine = { preset: machine.preset, 'interpolator.filters': 99 }))
      await attempt(() => (element.machine = 'no such machine'))
      await attempt(() => (element.machine = '{"broken'))
      await attempt(() => (element.machine = null))
      await attempt(() => ((element.machine = machine), (element.tolerances = [-1])))
      await attempt(() => ((element.tolerances = [0.01]), (element.dialect = 'esperanto')))
      await attempt(() => ((element.dialect = null), element.setAttribute('program-src', 'samples/none.nc')))
      // A newer request takes the place of an older one.
      element.setAttribute('program-src', 'samples/pocket.nc')
      const older = element.compute().catch((error) => error.kind)
      const newer = await element.compute()
      return { heard, tried, older: await older, times: newer.runs.length, inSight: element.shadowRoot.textContent }
    })
    assert.deepEqual(kinds.tried, ['machine', 'machine', 'machine', 'machine', 'tolerances', 'dialect', 'program'])
    assert.deepEqual([...new Set(kinds.heard)], ['machine', 'tolerances', 'dialect', 'program'])
    assert.equal(kinds.older, 'cancelled')
    assert.equal(kinds.times, 1)
    assert.match(kinds.inSight, /CAM says/)
    // The browser itself notes the program that is not there.
    assert.deepEqual(
      errors.splice(0).filter((text) => !/404|none\.nc/.test(text)),
      [],
    )
  },
)

exampleTest(
  'a portal of another origin has its program quoted in a frame',
  ({ plain, portal }) => `${portal.origin}/portal.html?truefeed=${plain.origin}`,
  async ({ page, plain, portal, requests }) => {
    assert.notEqual(plain.origin, portal.origin)
    await page.waitForFunction(() => document.querySelector('#said').textContent === 'Ready.')
    await page.click('button')
    await page.waitForFunction(() => / a part, /.test(document.querySelector('#said').textContent), null, { timeout: 60_000 })
    const program = join(scratch, 'order.nc')
    writeFileSync(program, await page.$eval('textarea', (area) => area.value))
    const { runs } = predicted(program, [0.01, 0.05])
    const expected = `${runs[0].cycle_time_s.toFixed(1)} s a part, ${runs[0].price.toFixed(2)} at 85 an hour`
    assert.equal(await page.textContent('#said'), expected)

    const frame = page.frames()[1]
    assert.equal(new URL(frame.url()).origin, plain.origin)
    assert.equal(await frame.$$eval('truefeed-quote tbody tr', (rows) => rows.length), 2)
    const inner = await frame.evaluate(() => document.documentElement.scrollHeight)
    await page.waitForFunction((height) => document.querySelector('iframe').offsetHeight >= height, inner)
    await shot(page, 'embed-portal')
    assert.ok(!requests.some((url) => url.startsWith(portal.origin) && url.endsWith('.wasm')), 'the portal computes nothing')
  },
)

/** A page that holds a frame and keeps all it says; `named` is whom the frame's address names. */
async function held({ page, plain, portal, named = portal.origin, at = portal.origin }) {
  await page.waitForLoadState('networkidle')
  await page.route('**/favicon.ico', (route) => route.fulfill({ status: 204 }))
  await page.goto(`${at}/example.css`)
  await page.evaluate(
    (source) => {
      window.said = []
      addEventListener('message', ({ data, origin }) => window.said.push({ ...data, origin }))
      const frame = document.createElement('iframe')
      frame.src = source
      document.body.append(frame)
      return new Promise((done) => (frame.onload = done))
    },
    `${plain.origin}/embed.html?origin=${encodeURIComponent(named)}`,
  )
}
const saidOf = (page) => page.evaluate(() => window.said)
const send = (page, message) => page.evaluate((message) => frames[0].postMessage(message, '*'), message)

exampleTest(
  'a frame refuses messages of other origins, versions and shapes, and none of them harms it',
  ({ plain }) => `${plain.origin}/page.html`,
  async ({ page, plain, portal }) => {
    await held({ page, plain, portal })
    await page.waitForFunction(() => window.said.some(({ type }) => type === 'ready'))

    // What is none of ours is passed over without a word.
    await page.evaluate(() => {
      window.said.length = 0
      for (const odd of [null, undefined, 0, '', 'truefeed', [], [1], true, new Date(), new Map(), {}, { type: 'get-quote', id: 1 }]) {
        frames[0].postMessage(odd, '*')
      }
    })

    /** Each with the kind of refusal it must get. */
    const refused = await page.evaluate(async () => {
      const machine = { preset: 'Older or heavy machine' }
      const own = (key, value) => Object.defineProperty({}, key, { value, enumerable: true })
      const circle = {}
      circle.circle = circle
      let deep = 1
      for (let depth = 0; depth < 1000; depth += 1) deep = [deep]
      // Written as JSON, it doubles forty times.
      let doubled = [1]
      for (let depth = 0; depth < 40; depth += 1) doubled = [doubled, doubled]
      const hostile = [
        ['version', { truefeed: 2, type: 'get-quote' }],
        ['version', { truefeed: '1', type: 'get-quote' }],
        ['version', { truefeed: { toString: 'x' }, type: 'get-quote' }],
        ['type', { truefeed: 1 }],
        ['type', { truefeed: 1, type: 'eval' }],
        ['type', { truefeed: 1, type: '__proto__' }],
        ['type', { truefeed: 1, type: 'constructor' }],
        ['type', { truefeed: 1, type: ['get-quote'] }],
        ['request', { truefeed: 1, type: 'get-quote', extra: 1 }],
        ['request', { truefeed: 1, type: 'get-quote', ...Object.fromEntries([['__proto__', { admin: 1 }]]), constructor: 1 }],
        ['request', { truefeed: 1, type: 'load-program' }],
        ['request', { truefeed: 1, type: 'load-program', program: 3 }],
        ['request', { truefeed: 1, type: 'load-program', program: { length: 5, byteLength: 5 } }],
        ['request', { truefeed: 1, type: 'load-program', program: 'G0', name: 'x'.repeat(1000) }],
        ['size', { truefeed: 1, type: 'load-program', program: new Uint8Array(65 * 1024 * 1024) }],
        ['request', { truefeed: 1, type: 'set-machine', machine: [] }],
        ['request', { truefeed: 1, type: 'set-machine', machine: null }],
        ['size', { truefeed: 1, type: 'set-machine', machine: { name: 'x'.repeat(100_000) } }],
        ['size', { truefeed: 1, type: 'set-machine', machine: circle }],
        ['request', { truefeed: 1, type: 'set-machine', machine: { big: 1n } }],
        ['request', { truefeed: 1, type: 'set-machine', machine: /Older or heavy machine/ }],
        ['request', { truefeed: 1, type: 'set-machine', machine: new Map([['preset', 'Older or heavy machine']]) }],
        ['request', { truefeed: 1, type: 'set-machine', machine: { ...machine, 'times.m_codes': new Date() } }],
        ['request', { truefeed: 1, type: 'set-machine', machine: { ...machine, 'rapid.feed_mm_min': NaN } }],
        ['size', { truefeed: 1, type: 'set-machine', machine: { doubled } }],
        ['size', { truefeed: 1, type: 'set-machine', machine: { holes: Array(1e8) } }],
        ['request', { truefeed: 1, type: 'set-tolerances', tolerances: 'all' }],
        ['request', { truefeed: 1, type: 'set-tolerances', tolerances: [NaN] }],
        ['request', { truefeed: 1, type: 'set-tolerances', tolerances: Array(33).fill(0.01) }],
        ['request', { truefeed: 1, type: 'set-theme', theme: { background: 'red' } }],
        ['request', { truefeed: 1, type: 'set-theme', theme: own('__proto__', 'red') }],
        ['request', { truefeed: 1, type: 'set-theme', theme: { '--truefeed-text': 'x'.repeat(1000) } }],
      ]
      hostile.forEach(([, message], id) => frames[0].postMessage({ id, ...message }, '*'))
      frames[0].postMessage({ truefeed: 1, type: 'get-quote' }, '*')
      frames[0].postMessage({ truefeed: 1, type: 'get-quote', id: { toString: 1 } }, '*')
      frames[0].postMessage({ truefeed: 1, type: 'get-quote', id: 'x'.repeat(1000) }, '*')

      // These are well formed, and refused by what they say.
      const judged = [
        ['machine', { machine: Object.defineProperty({ ...machine }, '__proto__', { value: { a: 1 }, enumerable: true }) }],
        ['machine', { machine: { ...machine, constructor: 1 } }],
        ['request', { machine: { ...machine, 'interpolator.filters': deep } }],
        ['machine', { machine: { ...machine, 'interpolator.filters': 1e9 } }],
        ['machine', { machine: '\u0000' }],
        ['machine', { machine: '\ud800' }],
        ['machine', { machine: { ...machine, '\udfff': 1 } }],
      ]
      const answerTo = async (id) => {
        for (;;) {
          const found = window.said.find((one) => one.id === id && one.type !== 'progress')
          if (found) return found
          await new Promise((done) => setTimeout(done, 20))
        }
      }
      const judgements = []
      for (const [index, [kind, message]] of judged.entries()) {
        frames[0].postMessage({ truefeed: 1, id: `set ${index}`, type: 'set-machine', ...message }, '*')
        frames[0].postMessage({ truefeed: 1, id: `load ${index}`, type: 'load-program', program: 'G1 X10 F100' }, '*')
        frames[0].postMessage({ truefeed: 1, id: `get ${index}`, type: 'get-quote' }, '*')
        judgements.push([kind, (await answerTo(`get ${index}`)).error?.kind])
      }
      const answers = await Promise.all(hostile.map((_, id) => answerTo(id)))
      const nameless = window.said.filter(({ id, error }) => id === null && error?.kind === 'request').length
      return { pairs: hostile.map(([kind], id) => [kind, answers[id].error?.kind]), judgements, nameless }
    })
    for (const [index, [expected, kind]] of [...refused.pairs, ...refused.judgements].entries()) {
      assert.equal(kind, expected, `message ${index}`)
    }
    assert.equal(refused.nameless, 3, 'messages without a proper id')

    // After all that it still quotes, bytes too.
    await page.evaluate(
      (text) => {
        const bytes = new TextEncoder().encode(text)
        const messages = [
          { id: 'a', type: 'set-machine', machine: 'Older or heavy machine' },
          { id: 'b', type: 'load-program', program: bytes, name: 'part.nc' },
          { id: 'c', type: 'get-quote' },
        ]
        for (const message of messages) frames[0].postMessage({ truefeed: 1, ...message }, '*')
      },
      readFileSync(SAMPLE, 'utf8'),
    )
    await page.waitForFunction(() => window.said.some(({ id, type }) => id === 'c' && type === 'quote'), null, { timeout: 60_000 })
    const said = await saidOf(page)
    assert.ok(said.every(({ origin, truefeed }) => origin === plain.origin && truefeed === 1))
    const { quote } = said.find(({ id, type }) => id === 'c' && type === 'quote')
    assert.equal(quote.program, 'part.nc')
    assert.ok(quote.runs[0].cycle_time_s > 10)
    assert.equal(await page.frames()[1].evaluate(() => ({}).admin), undefined, 'no prototype was changed')
  },
)

longExampleTest(
  'a frame says nothing to an origin that its address does not name',
  ({ plain }) => `${plain.origin}/page.html`,
  async ({ page, plain, portal, errors }) => {
    for (const named of ['https://portal.example', 'null', '*', `${portal.origin}/path`, 'javascript:alert(1)', '']) {
      await held({ page, plain, portal, named })
      await send(page, { truefeed: 1, id: 1, type: 'get-quote' })
      await send(page, { truefeed: 1, id: 2, type: 'load-program', program: 'G0 X1' })
      await page.waitForTimeout(150)
      assert.deepEqual(await saidOf(page), [], named)
    }
    // Chromium notes each message that it did not deliver.
    const undelivered = errors.splice(0).filter((text) => !/Failed to execute 'postMessage'/.test(text))
    assert.deepEqual(undelivered, [])

    // A window that is not the parent is not heard either, though of the right origin.
    await held({ page, plain, portal })
    await page.waitForFunction(() => window.said.some(({ type }) => type === 'ready'))
    const before = (await saidOf(page)).length
    await page.evaluate(
      () =>
        new Promise((done) => {
          const other = document.createElement('iframe')
          other.src = location.href
          other.onload = () => {
            other.contentWindow.eval("parent.frames[0].postMessage({ truefeed: 1, id: 9, type: 'get-quote' }, '*')")
            setTimeout(done, 150)
          }
          document.body.append(other)
        }),
    )
    const later = (await saidOf(page)).slice(before).filter(({ id }) => id === 9)
    assert.deepEqual(later, [])
  },
)

longExampleTest(
  'each message gets one answer that says what is wrong, and no text is refused for what stands in it',
  ({ plain }) => `${plain.origin}/page.html`,
  async ({ page, plain, portal }) => {
    await held({ page, plain, portal })
    await page.waitForFunction(() => window.said.some(({ type }) => type === 'ready'))
    const ask = async (...messages) => {
      // As JSON: the browser's debugger takes no half of a surrogate pair.
      await page.evaluate((messages) => {
        window.said.length = 0
        for (const message of JSON.parse(messages)) frames[0].postMessage({ truefeed: 1, ...message }, '*')
      }, JSON.stringify(messages))
      await page.waitForFunction((most) => window.said.filter(({ type }) => type === 'ready' || type === 'error' || type === 'quote').length >= most, messages.length)
      const said = await saidOf(page)
      return messages.map(({ id }) => said.filter((one) => one.id === id && one.type !== 'progress'))
    }
    const machine = { preset: 'Older or heavy machine' }
    const [half, other] = ['\\ud83d', '\\ude00'].map((code) => JSON.parse(`"${code}"`))
    const [set, loaded, quoted] = await ask(
      { id: 'm', type: 'set-machine', machine },
      { id: 'p', type: 'load-program', program: `G1 X10 F100 (${half})`, name: `a${half}b${other}${half}${other}\\ud800.nc` },
      { id: 'q', type: 'get-quote' },
    )
    assert.deepEqual(
      [set, loaded, quoted].map((all) => all.map(({ type }) => type)),
      [['ready'], ['ready'], ['quote']],
      JSON.stringify([set, loaded, quoted]),
    )
    assert.equal(quoted[0].quote.program, `a\ufffdb\ufffd${half}${other}\\ud800.nc`)

    const [[wrong]] = await ask({ id: 'd', type: 'set-machine', machine: ['list'] })
    assert.match(wrong.error.message, /“machine” of “set-machine” must be a text, or a plain object/)
  },
)

longExampleTest(
  'a machine of objects in objects gets one answer, and what the browser cannot read gets one too',
  ({ plain }) => `${plain.origin}/page.html`,
  async ({ page, plain, portal }) => {
    await held({ page, plain, portal })
    await page.waitForFunction(() => window.said.some(({ type }) => type === 'ready'))
    await send(page, { truefeed: 1, id: 'program', type: 'load-program', program: 'G1 X10 F100\n' })
    for (const depth of [300, 3000]) {
      await page.evaluate((depth) => {
        window.said.length = 0
        let machine = {}
        for (let level = 0; level < depth; level += 1) machine = { machine }
        const say = (id, message) => frames[0].postMessage({ truefeed: 1, id, ...message }, '*')
        say('deep', { type: 'set-machine', machine })
        say('refused', { type: 'get-quote' })
        say('sound', { type: 'set-machine', machine: { preset: 'Older or heavy machine' } })
        say('quoted', { type: 'get-quote' })
      }, depth)
      await page.waitForFunction(() => window.said.some(({ id, type }) => id === 'quoted' && type !== 'progress'), null, { timeout: 60_000 })
      const said = (await saidOf(page)).filter(({ type }) => !['resize', 'progress'].includes(type))
      const answers = (id) => said.filter((one) => one.id === id).map(({ type, error }) => error?.kind ?? type)
      // A browser that does not read it cannot tell its id either, and the frame keeps the machine that it had.
      const isRead = answers('deep').length > 0
      assert.ok(isRead || depth === 3000, `${depth} levels`)
      if (isRead) assert.deepEqual(answers('deep'), ['ready'], `${depth} levels`)
      // Some browsers say that they could not read it, others hand over nothing at all.
      else
        assert.ok(
          answers(null).every((kind) => kind === 'request'),
          `${depth} levels: ${answers(null)}`,
        )
      assert.equal(answers('refused').length, 1, `${depth} levels: ${answers('refused')}`)
      assert.ok(!isRead || ['machine', 'cancelled'].includes(answers('refused')[0]), `${depth} levels: ${answers('refused')}`)
      assert.deepEqual([answers('sound'), answers('quoted')], [['ready'], ['quote']], `${depth} levels`)
    }

    // The browser's event of a message that it could not read, which the frame hears of its portal alone.
    for (const [origin, count] of [
      [portal.origin, 1],
      ['https://other.example', 0],
    ]) {
      await page.evaluate(() => void (window.said.length = 0))
      await page.frames()[1].evaluate((origin) => {
        window.dispatchEvent(new MessageEvent('messageerror', { origin, source: window.parent }))
      }, origin)
      await send(page, { truefeed: 1, id: 'after', type: 'set-tolerances', tolerances: [0.02] })
      await page.waitForFunction(() => window.said.some(({ id }) => id === 'after'))
      const unread = (await saidOf(page)).filter(({ type }) => type === 'error')
      assert.deepEqual(
        unread.map(({ id, error }) => [id, error.kind]),
        Array(count).fill([null, 'request']),
        origin,
      )
    }
  },
)

for (const count of [1000, 10_000, 50_000]) {
  longExampleTest(
    `of ${count} requests in a row each is answered, and those that are superseded start no worker`,
    ({ plain }) => `${plain.origin}/page.html`,
    async ({ page, plain, portal }, context) => {
      // Workers are counted where they are made, from before the frame loads.
      await page.addInitScript(() => {
        const Started = window.Worker
        window.started = 0
        window.Worker = class extends Started {
          constructor(...given) {
            super(...given)
            window.started += 1
          }
        }
      })
      await held({ page, plain, portal })
      await page.waitForFunction(() => window.said.some(({ type }) => type === 'ready'))
      const { answers, ms } = await page.evaluate(
        (count) =>
          new Promise((done) => {
            const left = new Set()
            const answers = {}
            addEventListener('message', ({ data: { id, type, error } }) => {
              if (type === 'progress' || !left.delete(id)) return
              const kind = error?.kind ?? type
              answers[kind] = (answers[kind] ?? 0) + 1
              if (left.size === 0) done({ answers, ms: performance.now() - start })
            })
            const start = performance.now()
            const send = (id, message) => (left.add(id), frames[0].postMessage({ truefeed: 1, id, ...message }, '*'))
            send('machine', { type: 'set-machine', machine: { preset: 'Older or heavy machine' } })
            send('program', { type: 'load-program', program: 'G1 X10 F100\nG1 Y10\n'.repeat(1000) })
            for (let id = 0; id < count; id += 1) send(id, id % 3 === 1 ? { type: 'set-tolerances', tolerances: [0.01 + 1e-7 * id] } : { type: 'get-quote' })
            send('last', { type: 'get-quote' })
          }),
        count,
      )
      const set = Math.floor((count + 1) / 3)
      assert.equal(answers.ready, 2 + set)
      assert.equal(answers.quote + answers.cancelled, count - set + 1, JSON.stringify(answers))
      assert.ok(answers.quote >= 1, 'the last of them is quoted')
      const started = await page.frames()[1].evaluate(() => window.started)
      context.diagnostic(`${count} messages are answered in ${Math.round(ms)} ms, ${started} workers are started`)
      // A wait for calm may end between two messages when the machine is busy; one worker each it is not.
      assert.ok(started <= 3 + count / 200, `${started} workers`)
    },
  )
}

test('the package quotes in Node as the command line does', async () => {
  const { quote, QuoteError } = await import(join(PACKAGE, 'npm/node.js'))
  const program = readFileSync(SAMPLE)
  const parts = []
  const options = { name: 'pocket.nc', onProgress: (part) => parts.push(part) }
  const result = await quote(program, MACHINE_FILE, [0.01, 0.05], options)
  const expected = predicted(SAMPLE, [0.01, 0.05])
  assertAlike(result, expected)
  assert.deepEqual(Object.keys(result).sort(), Object.keys(expected).sort())
  assert.ok(parts.length > 0 && parts.every((part, index) => part >= (parts[index - 1] ?? 0) && part <= 1))
  assert.deepEqual(await quote(program.toString(), MACHINE_FILE, [0.01, 0.05], options), result)

  for (const [kind, ...request] of [
    ['machine', program, 'nothing'],
    ['machine', program, undefined],
    ['machine', program, { preset: MACHINE, 'rapid.feed_mm_min': -1 }],
    ['request', program, 3],
    ['request', program, MACHINE, 'all'],
    ['tolerances', program, MACHINE, [0]],
    ['dialect', program, MACHINE, [], { dialect: 'esperanto' }],
    ['program', 3, MACHINE],
    ['cancelled', program, MACHINE, [], { signal: AbortSignal.abort() }],
  ]) {
    const isOfKind = (error) => error instanceof QuoteError && error.kind === kind && error.message.length > 10
    await assert.rejects(quote(...request), isOfKind, `${kind} ${request.slice(1)}`)
  }
  await assert.rejects(quote(program, { preset: MACHINE, 'rapid.feed_mm_min': -1 }), (error) => error.faults[0].key === 'rapid.feed_mm_min')
})

test('a bundle of the package quotes, by function and by component', { timeout: 120_000 }, async () => {
  const root = mkdtempSync(join(scratch, 'bundle-'))
  mkdirSync(join(root, 'node_modules'))
  symlinkSync(PACKAGE, join(root, 'node_modules/truefeed'))
  writeFileSync(join(root, 'index.html'), '<!doctype html><title>Portal</title><truefeed-quote></truefeed-quote><script type="module" src="portal.js"></script>')
  const request = [readFileSync(SAMPLE, 'utf8'), MACHINE_FILE, [0.01, 0.05]].map((part) => JSON.stringify(part)).join(', ')
  writeFileSync(join(root, 'portal.js'), `import { quote } from 'truefeed'\nimport 'truefeed/element'\nquote(${request}).then((result) => { window.quoted = result })`)
  await build({ root, configFile: false, logLevel: 'error' })
  const server = await serve(0, [join(root, 'dist')])
  const { page, errors, requests, close } = await openPage({ path: '/icon.svg' })
  try {
    await page.goto(`${server.origin}/`)
    requests.length = 0
    const quoted = await page.waitForFunction(() => window.quoted)
    assertAlike(await quoted.jsonValue(), predicted(SAMPLE, [0.01, 0.05]))
    await page.waitForFunction(() => document.querySelector('truefeed-quote').shadowRoot?.textContent.includes('Drop a G-code program'))
    assert.deepEqual(
      errors.filter((error) => !error.includes('/favicon.ico')),
      [],
    )
    assert.deepEqual(leaving(requests, server.origin), [])
  } finally {
    await close()
    await server.close()
  }
})

test('the example in Node quotes a folder', () => {
  const folder = mkdtempSync(join(scratch, 'folder-'))
  for (const name of ['a.nc', 'b.nc']) writeFileSync(join(folder, name), readFileSync(SAMPLE))
  const machine = join(scratch, 'folder.toml')
  writeFileSync(machine, MACHINE_FILE)
  const example = join(ROOT, 'examples/embedding/folder.mjs')
  const { stdout, status } = spawnSync('node', [example, folder, machine, '0.01', '0.05'], { encoding: 'utf8' })
  assert.equal(status, 0)
  const rows = stdout
    .trim()
    .split('\n')
    .map((row) => row.split(','))
  assert.equal(rows.length, 5)
  const { runs } = predicted(SAMPLE, [0.01, 0.05])
  assert.deepEqual(
    rows.slice(1).map(([name, tolerance, , time]) => [name, Number(tolerance), time]),
    ['"a.nc"', '"b.nc"'].flatMap((name) => runs.map((run) => [name, run.tolerance_mm, run.cycle_time_s.toFixed(2)])),
  )
  const refused = spawnSync('node', [example, folder, 'nothing'], { encoding: 'utf8' })
  assert.equal(refused.status, 2)
  assert.match(refused.stderr, /there is no machine “nothing”/)
})

longPlainTest('the types of the package hold for those who use it', {}, () => {
  const user = join(scratch, 'user')
  mkdirSync(join(user, 'node_modules'), { recursive: true })
  symlinkSync(PACKAGE, join(user, 'node_modules/truefeed'))
  const check = (text) => {
    writeFileSync(join(user, 'use.ts'), text)
    const flags = ['--noEmit', '--strict', '--module', 'nodenext', '--target', 'es2022', '--lib', 'es2022,dom']
    return spawnSync(join(ROOT, 'node_modules/.bin/tsc'), [...flags, 'use.ts'], { cwd: user, encoding: 'utf8' })
  }
  writeFileSync(join(user, 'package.json'), '{"type": "module"}')
  const good = check(`import { quote, QuoteError, type Quote } from 'truefeed'
import 'truefeed/element'
const made: Quote = await quote('G1 X10 F100', { preset: 'x', 'rapid.feed_mm_min': 1 }, [0.01, null], { dialect: 'siemens' })
const time: number = made.runs[0].cycle_time_s
const element = document.querySelector('truefeed-quote')!
element.addEventListener('quote', ({ detail }) => detail.runs.map((run) => run.price + time))
element.machine = 'x'
export const kind = (error: unknown) => (error instanceof QuoteError ? error.kind : '')
`)
  assert.equal(good.stdout, '')
  const bad = check(`import { quote } from 'truefeed'
export const wrong: string = (await quote(3, 'x')).runs
`)
  assert.match(bad.stdout, /TS2345/)
  const version = (text, pattern) => text.match(pattern)[1]
  const cargo = readFileSync(join(ROOT, 'Cargo.toml'), 'utf8')
  const [release] = JSON.parse(readFileSync(join(PACKAGE, 'package.json'), 'utf8')).version.split('+')
  assert.equal(release, version(cargo, /^version = "(.+)"/m), 'the last tag is of the version in Cargo.toml')
  for (const name of ['LICENSE-APACHE', 'LICENSE-MIT', 'www/pkg/notices.txt']) assert.match(readFileSync(join(PACKAGE, name), 'utf8'), /Permission is hereby granted|Apache License/, name)
})
