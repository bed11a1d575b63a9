// The main journey in Firefox: programs dropped, a tolerance chosen, a price, the path and the charts, a recording compared, all of
// it kept. What the page does is tested in Chromium; here, that another engine does it too.

import assert from 'node:assert/strict'
import { join } from 'node:path'
import { findFirefox, openInFirefox } from './firefox.mjs'
import { openPage } from './harness.mjs'
import { ROOT, computed, cycleTimes, drop, frame, longTest, pageTest, pixelsOfCurves } from './steps.mjs'

const SAMPLE = join(ROOT, 'www/samples/pocket.nc')
const RECORDED = ['standin.nc', 'standin.csv'].map((name) => join(ROOT, 'www/samples', name))
const missing = findFirefox() ? false : 'no Firefox 143 or newer here; scripts/setup test installs it where apt has it as firefox-esr'

const IN_FIREFOX = { skip: missing, open: () => openInFirefox() }
/** A test on a page of its own in Firefox. @param {string} name @param {Parameters<typeof pageTest>[1]} body */
const firefoxTest = (name, body) => pageTest(name, body, IN_FIREFOX)
/** A test in Firefox that runs in the full suite only. @param {string} name @param {Parameters<typeof pageTest>[1]} body */
const longFirefoxTest = (name, body) => longTest(name, body, IN_FIREFOX)

/** Colours that are on a canvas. */
const colours = (page, selector) =>
  page.$eval(selector, (canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height)
    return new Set(Array.from({ length: data.length / 4 }, (_, index) => data.slice(4 * index, 4 * index + 3).join())).size
  })

firefoxTest('Firefox: a program dropped has its times, curves, path and price, which are kept', async ({ page }) => {
  await drop(page, 'body', [SAMPLE])
  await computed(page)
  await frame(page)
  const times = await cycleTimes(page)
  assert.ok(
    (await pixelsOfCurves(page)).every((count) => 50 < count),
    'every curve is drawn',
  )
  assert.ok(20 < (await colours(page, '#path canvas')), 'the path is drawn')

  await page.fill('#term-rates-hourly', '85')
  await page.fill('#term-quantity', '25')
  await page.waitForFunction(() => /€/.test(document.querySelector('#quote .headline')?.textContent ?? ''))
  const price = await page.textContent('#quote .headline b')
  const amount = Number(price.replace(/[^\d.]/g, ''))
  assert.ok(Math.abs(amount - (25 * 85 * times[0]) / 3600) < 0.5, `${price} for ${times[0]} s`)

  // Another tolerance is quoted, taken back, and the view of the chart follows the keys.
  await page.click('#results .others button')
  await page.waitForFunction((before) => document.querySelector('#quote .headline b').textContent !== before, price)
  await page.click('#history .undo-change')
  await page.waitForFunction((before) => document.querySelector('#quote .headline b').textContent === before, price)
  const span = await page.getAttribute('#chart .plot', 'data-span')
  await page.focus('#chart .plot')
  await page.keyboard.press('+')
  await page.waitForFunction((before) => document.querySelector('#chart .plot').dataset.span !== before, span)
  await page.click('#path .play')
  await page.waitForFunction(() => document.querySelector('#path .clock .now').textContent !== '0:00:00')

  // The times are those of the other engine, and a reload loses nothing.
  const other = await openPage()
  try {
    await other.page.setInputFiles('#files', SAMPLE)
    await computed(other.page)
    assert.deepEqual(times, await cycleTimes(other.page))
  } finally {
    await other.close()
  }
  await page.reload()
  await page.waitForSelector('html[data-ready]')
  await computed(page)
  assert.deepEqual(await cycleTimes(page), times)
  await page.waitForFunction((before) => document.querySelector('#quote .headline b')?.textContent === before, price)
})

longFirefoxTest('Firefox: a job is kept, opened, kept again and computed from its files', async ({ page }) => {
  const total = () => page.textContent('#program .total')
  const ready = () => page.waitForFunction(() => /\d:\d\d/.test(document.querySelector('#program .total')?.textContent) && document.querySelector('#progress').hidden, null, { timeout: 120_000 })
  await page.click('#welcome .sample-job')
  await ready()
  const before = await total()
  await page.click('[popovertarget="jobs"]')
  await page.click('#jobs button.main')
  await page.waitForSelector('#jobs .kept b')
  await page.click('#jobs button:has-text("New job")')
  await page.click('#jobs .kept button >> nth=0')
  await ready()
  await page.click('[popovertarget="jobs"]')
  await page.click('#jobs button.main')
  await page.waitForFunction(() => /is kept/.test(document.querySelector('#jobs').textContent))
  await page.keyboard.press('Escape')
  // Another machine computes from the files again.
  await page.selectOption('#preset', { index: 2 })
  await page.waitForFunction((before) => document.querySelector('#program .total').textContent !== before && /\d:\d\d/.test(document.querySelector('#program .total').textContent), before, {
    timeout: 120_000,
  })
  assert.ok(await page.isHidden('#failure'))
})

firefoxTest('Firefox: a recording is compared with the program it is of', async ({ page }) => {
  await drop(page, 'body', [SAMPLE, ...RECORDED])
  await page.waitForFunction(() => document.querySelector('#recording .sentence') && document.querySelector('#progress').hidden, null, { timeout: 120_000 })
  assert.equal(await page.$eval('#recording .pairs select', (select) => select.selectedOptions[0].textContent), 'standin.nc')
  assert.match(await page.textContent('#recording .sentence'), /^The machine took [\d.]+ s, the simulation [\d.]+ s/)
})
