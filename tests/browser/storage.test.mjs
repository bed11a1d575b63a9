// Whatever stands in the browser's storage, written by another version of the page, by hand or cut short, the page starts and
// computes; and where the browser keeps nothing, it does as well.

import assert from 'node:assert/strict'
import { computed, longTest } from './steps.mjs'

const PROGRAM = { name: 'part.nc', mimeType: 'text/plain', buffer: Buffer.from('G21 G90 G94\nG1 X10 F600\nY10\nX0\nM30\n') }

/** JSON of every shape, none of them a proper record. */
const SHAPES = ['', 'nonsense', '{"cut": "sho', 'null', 'true', '7', '"text"', '[]', '[null]', '{}', '[{"name": {}}]', '[[["deep"]]]']

/** Settings with one part of another shape, or of a value that no version would write. */
const parts = [
  { values: [1], terms: 'x' },
  { values: { 'rapid.feed_mm_min': { a: 1 }, 'interpolator.filters': [], 'times.m_codes': 3, 'axes.x.backlash_mm': true } },
  { values: { nothing: 1, 'no.such.key': 2 } },
  { values: 'x', terms: [1, 2], tolerances: {}, preset: 5, beside: [], quoted: {}, programmed: 'yes' },
  { terms: { reference: {}, quantities: 'x', currency: [] } },
  { tolerances: Array.from({ length: 5000 }, (_, index) => 0.001 * (index + 1)) },
  { tolerances: [null] },
  { tolerances: [0.01, 'x'] },
  { tolerances: [-1, 0] },
  { preset: 'no such machine', beside: '__proto__', quoted: '<img src=x onerror=alert(1)>' },
].map((settings) => JSON.stringify(settings))
parts.push('{"values":{"__proto__":1,"constructor":2}}', '{"__proto__":{"tolerances":[1]}}', `{"values":${'['.repeat(5000)}${']'.repeat(5000)}}`)

/** What a machine that was kept may look like. */
const machines = ['[{"name":"x"}]', '[{"name":"x","rapid.feed_mm_min":{"a":1},"toString":2,"no.such.key":3}]', '[{"name":""},null,5,[],"x"]']

longTest('whatever stands in the storage, the page starts and computes', async ({ page, errors }) => {
  const keys = ['truefeed.settings.1', 'truefeed.settings.before.1', 'truefeed.machines.1', 'truefeed.tab']
  /** What stands under each key, for one start each. */
  const poisons = [...SHAPES.map((text) => [text, text, text, text]), ...parts.map((text) => [text, text, '[]', 'x'.repeat(100_000)]), ...machines.map((text) => ['{}', 'null', text, '__proto__'])]
  for (const poison of poisons) {
    await page.evaluate(
      ([keys, poison]) => {
        localStorage.clear()
        sessionStorage.clear()
        keys.forEach((key, index) => (key.endsWith('.tab') ? sessionStorage : localStorage).setItem(key, poison[index]))
      },
      [keys, poison],
    )
    const name = poison.map((text) => text.slice(0, 60)).join(' | ')
    await page.reload()
    await page.waitForSelector('html[data-ready]').catch(() => assert.fail(`the page does not start with ${name}: ${errors}`))
    assert.ok(await page.isHidden('#failure'), `${name}: ${await page.textContent('#failure')}`)
    assert.deepEqual(errors, [], name)
    const chips = await page.locator('.chip').count()
    assert.ok(0 < chips && chips < 10, `${chips} tolerances with ${name}`)
    // The settings from before can be had back, and all machines chosen, without a fault that no field shows.
    const undo = page.locator('#notice .back')
    if (await undo.isVisible()) await undo.click()
    for (const index of (await page.$$eval('#preset option', (all) => all.map(({ value }) => value))).reverse()) await page.selectOption('#preset', index)
    assert.equal(await page.locator('#machine [aria-invalid]').count(), 0, name)
  }
  await page.setInputFiles('#files', PROGRAM)
  await computed(page)
})

longTest('a tab whose files cannot be read begins empty', async ({ page }) => {
  await page.setInputFiles('#files', PROGRAM)
  await computed(page)
  const records = [
    null,
    7,
    'x',
    [],
    {},
    { programs: 3, recordings: [] },
    { programs: [{}], recordings: [] },
    { programs: [{ id: 1, name: 'a.nc', file: 'G1 X1' }], recordings: [] },
    { programs: [], recordings: [{ id: 1, name: 'a.csv', bytes: 'x' }] },
    { programs: [], recordings: [], calibration: 7, diagnosis: 'x', sample: [] },
    { programs: [], recordings: [], calibration: {}, diagnosis: { runs: 5 }, sample: { values: 1 } },
  ]
  for (const record of records) {
    // The page writes its own when it is left; a fresh name holds what stands there.
    await page.evaluate(
      (record) =>
        new Promise((done) => {
          sessionStorage.setItem('truefeed.tab', 'poisoned')
          const asked = indexedDB.open('truefeed', 1)
          asked.onsuccess = () => {
            const written = asked.result.transaction('tabs', 'readwrite')
            written.objectStore('tabs').put(record, 'poisoned')
            written.oncomplete = () => (asked.result.close(), done())
          }
        }),
      record,
    )
    await page.reload()
    await page.waitForSelector('html[data-ready]', { timeout: 20_000 }).catch(() => assert.fail(`the page does not start with ${JSON.stringify(record)}`))
    assert.equal(await page.locator('.choose').count(), 0)
    await page.setInputFiles('#files', PROGRAM)
    await computed(page)
    assert.ok(await page.isHidden('#failure'), JSON.stringify(record))
  }
})

longTest('a browser without room, or that keeps nothing at all, still computes', async ({ page, origin }) => {
  const devtools = await page.context().newCDPSession(page)
  await devtools.send('Storage.overrideQuotaForOrigin', { origin, quotaSize: 0 })
  const full = { ...PROGRAM, buffer: Buffer.concat([PROGRAM.buffer, Buffer.from(`(${'x'.repeat(80)})\n`.repeat(50_000))]) }
  await page.setInputFiles('#files', full)
  await computed(page)
  assert.ok(await page.isHidden('#failure'))

  await page.addInitScript(() => {
    const refuse = () => {
      throw new DOMException('no storage', 'SecurityError')
    }
    for (const key of ['localStorage', 'sessionStorage', 'indexedDB']) Object.defineProperty(window, key, { get: refuse })
  })
  await page.reload()
  await page.waitForSelector('html[data-ready]')
  await page.setInputFiles('#files', PROGRAM)
  await computed(page)
  assert.ok(await page.isHidden('#failure'))
})
