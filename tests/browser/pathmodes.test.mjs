// The program's own tolerances on the page: a column of their own, where each holds, and the user's beside it.

import assert from 'node:assert/strict'
import { writeFileSync, mkdtempSync, rmSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after } from 'node:test'
import { atEverySize, computed, cycleTimes, frame, longTest, pageTest, pixelsOfCurves, predicted, shot, span } from './steps.mjs'

const folder = mkdtempSync(join(tmpdir(), 'truefeed-modes-'))
after(() => rmSync(folder, { recursive: true }))

/** A zigzag of square corners, 10 mm apart. */
const zigzag = (count, y) => Array.from({ length: count }, (_, i) => (i % 2 ? `Y${y + 5 * (i + 1)}` : `X${i % 4 ? 0 : 20}`)).join('\n')
const ROUGH_AND_FINE = `G21 G90 G64
G0 X0 Y-10
F3000
G64 P0.1
G1 ${zigzag(20, 0)}
G64 P0.002
${zigzag(20, 100)}
G61
X30
G64
Y0
M30
`
const WITHOUT = 'G21 G90\nG1 F3000 X20\nY20\nX0\n'

const program = (name, text) => {
  const path = join(folder, name)
  writeFileSync(path, text)
  return path
}
const labels = (page) => page.$$eval('.chip', (chips) => chips.map((chip) => chip.querySelector('.label').textContent))
const programmedTime = (page) => page.$eval('#tolerances tr.programmed data', (data) => Number(data.value))

pageTest("a program's own tolerances are its first column, and the user's hold all over beside it", async ({ page }) => {
  const path = program('rough-and-fine.nc', ROUGH_AND_FINE)
  await page.setInputFiles('#files', path)
  await computed(page)
  assert.deepEqual(await labels(page), ['as programmed', '10 µm', '20 µm', '50 µm'])
  assert.equal(await page.textContent('#tolerances tbody tr:first-child th'), 'as programmed')

  const { runs: own } = await predicted(page, path, [])
  assert.equal(own.length, 1)
  assert.ok(Math.abs((await programmedTime(page)) / own[0].cycle_time_s - 1) <= 1e-9)
  const { runs } = await predicted(page, path)
  const times = await cycleTimes(page)
  assert.deepEqual(
    times.map((time) => time.toFixed(6)),
    runs.map((run) => run.cycle_time_s.toFixed(6)),
  )
  assert.ok(!times.includes(await programmedTime(page)), 'the program asks for another time')

  // Where each holds, as the command line says it.
  const parts = await page.$$eval('.held li', (items) => items.map((item) => item.textContent))
  assert.equal(parts.length, own[0].tolerances.length)
  assert.match(parts[0], /^line 2 10 µm, the machine’s/)
  assert.match(parts[1], /^lines 5–24 100 µm G64 P0\.1$/)
  assert.match(parts[2], /^lines 26–45 2 µm G64 P0\.002$/)
  assert.match(parts[3], /^line 47 exact stops G61$/)

  await frame(page)
  assert.ok((await pixelsOfCurves(page)).every((pixels) => pixels > 80))
  await atEverySize(page, 'pathmodes')

  await page.click('.held li:nth-child(3) button')
  const [from, to] = await span(page)
  const [begin, end] = own[0].tolerances[2].distance_mm
  assert.ok(from <= begin && end <= to && to - from < 3 * (end - begin), `${from} to ${to} mm in sight`)
  await shot(page, 'pathmodes-part')
})

pageTest('where the time goes has a column for the program’s own tolerances, and each the colour of its chip', async ({ page }) => {
  const path = program('rough-and-fine.nc', ROUGH_AND_FINE)
  await page.setInputFiles('#files', path)
  await computed(page)
  const titles = () => page.$$eval('#breakdown .kinds th[scope="col"]:not(:first-child)', (all) => all.map((title) => title.textContent))
  const colours = (selector) => page.$$eval(selector, (all) => all.map((swatch) => getComputedStyle(swatch).backgroundColor))
  assert.deepEqual(await titles(), await labels(page))
  assert.deepEqual(await colours('#breakdown .kinds .swatch'), await colours('.chip .swatch'))
  const cutting = () => page.$$eval('#breakdown .kinds tbody tr:first-child td', (all) => all.map((cell) => cell.textContent))
  const [own, first] = await cutting()
  const { runs } = await predicted(page, path, [])
  assert.equal(own, `${runs[0].breakdown.cutting_s.toFixed(1)} s`)

  // Each of them can be chosen for the operations.
  const choice = '#breakdown select'
  assert.deepEqual(await page.$$eval(`${choice} option`, (all) => all.map((option) => option.textContent)), await labels(page))
  await page.selectOption(choice, { index: 0 })
  assert.equal(await page.textContent('#breakdown .parts tbody tr:first-child td:nth-child(6)'), own)

  // Without it, the colours move up with the chips.
  await page.click('.chip:first-child button')
  assert.deepEqual(await titles(), await labels(page))
  assert.deepEqual(await colours('#breakdown .kinds .swatch'), await colours('.chip .swatch'))
  assert.equal((await cutting())[0], first)
})

longTest('the column is taken away, comes back, and is remembered', async ({ page }) => {
  await page.setInputFiles('#files', [program('own.nc', ROUGH_AND_FINE), program('without.nc', WITHOUT)])
  await page.waitForFunction(() => document.querySelectorAll('.choose').length === 2)
  await computed(page)
  assert.equal((await labels(page))[0], 'as programmed')

  await page.click('.choose >> nth=1')
  await computed(page)
  assert.deepEqual(await labels(page), ['10 µm', '20 µm', '50 µm'])
  assert.ok(await page.isHidden('#tolerances .own'))
  assert.equal((await page.$$('.held')).length, 0)

  await page.click('.choose >> nth=0')
  await computed(page)
  await page.click('.chip:first-child button')
  assert.deepEqual(await labels(page), ['10 µm', '20 µm', '50 µm'])
  assert.equal((await page.$$('#tolerances tbody tr')).length, 3)
  assert.ok(await page.isVisible('#tolerances .own'))
  assert.ok((await page.$$('.held li')).length > 0, 'where they hold is still said')

  await page.reload()
  await page.waitForSelector('html[data-ready]')
  await page.setInputFiles('#files', program('own.nc', ROUGH_AND_FINE))
  await computed(page)
  assert.deepEqual(await labels(page), ['10 µm', '20 µm', '50 µm'])
  await page.click('#tolerances .own')
  await computed(page)
  assert.equal((await labels(page))[0], 'as programmed')
  assert.ok((await programmedTime(page)) > 0)
})
