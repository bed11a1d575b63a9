// What would save time: every change is as large as the page says once it is tried, and goes away again.

import assert from 'node:assert/strict'
import { join } from 'node:path'
import { ROOT, atEverySize, computed, cycleTimes, drop, longTest, pageTest } from './steps.mjs'

const SAMPLE = join(ROOT, 'www/samples/pocket.nc')
const PROGRAMS = ['10', '20', '30'].map((number) => join(ROOT, `www/samples/bracket-${number}.nc`))

/** Waits until all changes are computed. */
const found = (page) => page.waitForFunction(() => document.querySelector('#savings progress').hidden && document.querySelector('#savings .result').childElementCount > 0, null, { timeout: 120_000 })

/** The rows of the table: texts of their cells. */
const rows = (page) => page.$$eval('#savings tbody tr', (all) => all.map((row) => [...row.cells].map((cell) => (cell.querySelector('span') ?? cell).textContent)))
/** The operations of the rows. */
const operations = (page) => page.$$eval('#savings tbody tr .of', (all) => all.map(({ textContent }) => textContent))
const number = (text) => Number(text.replace('−', '-').replace(/[^\d.-]/g, ''))

pageTest('a change saves what the panel says when it is tried, and is taken back with a click', async ({ page }) => {
  await drop(page, 'main', [SAMPLE])
  await computed(page)
  await page.fill('#term-rates-hourly', '85')
  await page.fill('#term-quantity', '25')
  const [first, second] = await cycleTimes(page)
  await page.click('#more [aria-controls="savings"]')
  await found(page)
  const all = await rows(page)
  const saved = all.map(([, seconds]) => number(seconds))
  assert.ok(all.length >= 2 && saved.every((own) => own < 0), `${saved}`)
  assert.deepEqual(
    saved,
    [...saved].sort((a, b) => a - b),
    'the largest comes first',
  )
  const row = all.find(([title]) => title === 'Contour tolerance 20 µm')
  assert.ok(Math.abs(number(row[1]) - (second - first)) < 0.06, `${row[1]} for ${second - first}`)
  assert.ok(Math.abs(number(row[3]) - (25 * 85 * (second - first)) / 3600) < 0.3, `${row[3]} of 25 parts`)

  const time = () => page.textContent('#results .time')
  const [before, price] = [await time(), await page.textContent('#quote .headline')]
  await page.click('#savings tr:has-text("20 µm") button')
  await computed(page)
  assert.equal(await page.textContent('#bar .tolerance .name'), '20 µm')
  assert.notEqual(await page.textContent('#quote .headline'), price)
  assert.match(await page.textContent('#savings .tried'), /Contour tolerance 20 µm/)
  await found(page)
  assert.ok(!(await rows(page)).some(([title]) => title === 'Contour tolerance 20 µm'), 'what was tried is no idea any more')
  await atEverySize(page, 'savings')
  await page.click('#savings .tried button')
  await computed(page)
  assert.deepEqual([await time(), await page.textContent('#quote .headline')], [before, price])
  assert.ok(await page.isHidden('#savings .tried'))
})

longTest('in a job each operation has changes of its own, and trying one leaves the others alone', async ({ page }) => {
  await drop(page, 'main', PROGRAMS)
  await computed(page)
  await page.waitForFunction(() => /\d:\d\d/.test(document.querySelector('#program .total')?.textContent ?? ''))
  await page.click('#more [aria-controls="savings"]')
  await found(page)
  const [of, ...others] = await operations(page)
  assert.ok(
    others.some((other) => other !== of),
    'several operations have something',
  )
  const times = () => page.$$eval('#program .choose .about', (about) => about.map(({ textContent }) => textContent))
  const before = await times()
  await page.click('#savings tbody tr:first-child button')
  await page.waitForFunction(
    (before) => [...document.querySelectorAll('#program .choose .about')].map(({ textContent }) => textContent).join() !== before && document.querySelector('#progress').hidden,
    before.join(),
  )
  const names = await page.$$eval('#program .choose .file', (files) => files.map(({ textContent }) => textContent))
  const changed = (await times()).flatMap((time, index) => (time === before[index] ? [] : [names[index]]))
  assert.deepEqual(changed, [of])
  await page.click('#savings .tried button')
  await page.waitForFunction((before) => [...document.querySelectorAll('#program .choose .about')].map(({ textContent }) => textContent).join() === before, before.join())
})
