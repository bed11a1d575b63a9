// The answer and what stands around it say the same: the tolerance that is quoted, its time, and how exact that is.

import assert from 'node:assert/strict'
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after } from 'node:test'
import { ROOT, computed, drop, longTest, pageTest } from './steps.mjs'

const SAMPLE = join(ROOT, 'www/samples/pocket.nc')
const scratch = mkdtempSync(join(tmpdir(), 'truefeed-answer-'))
after(() => rmSync(scratch, { recursive: true }))

pageTest('path, player and operations follow the tolerance that is quoted, until another one is chosen by hand', async ({ page }) => {
  await drop(page, 'main', [SAMPLE])
  await computed(page)
  const shown = () => page.$eval('#path .at', (select) => select.selectedOptions[0].textContent)
  const player = () => page.textContent('#path .player .whole')
  const listed = () => page.textContent('#program .choose .about')
  assert.equal(await shown(), '10 µm')
  const [time, list] = [await player(), await listed()]
  assert.match(list, /^\d:\d\d:\d\d$/, 'the list has the time that is quoted, and no spread of tolerances')
  await page.click('#results .others button:has-text("50 µm")')
  assert.equal(await shown(), '50 µm')
  assert.notEqual(await player(), time)
  assert.notEqual(await listed(), list)
  await page.selectOption('#path .at', { label: '20 µm' })
  await page.click('#results .others button:has-text("10 µm")')
  assert.equal(await shown(), '20 µm', 'what was chosen by hand stays')
})

longTest('a time of which much is in doubt is no bold answer', async ({ page }) => {
  const doubtful = join(scratch, 'doubtful.nc')
  writeFileSync(doubtful, 'G21 G90\nG28 Z0\nG0 X0 Y0\nG1 X50 F6000\nY50\nG28 X0\nG28 Y0\nM30\n')
  await drop(page, 'main', [SAMPLE])
  await computed(page)
  const weight = () => page.$eval('#results .time', (time) => Number(getComputedStyle(time).fontWeight))
  const sure = await weight()
  await drop(page, 'main', [doubtful])
  await page.click('#program li:first-child .remove')
  await computed(page)
  assert.match(await page.textContent('#results .doubt'), /up to .* s/)
  assert.ok((await weight()) < sure, 'a time in doubt is as bold as a sure one')
})

pageTest('the bar says with one figure how exact the time is, and nothing that the range does not', async ({ page }) => {
  await drop(page, 'main', [SAMPLE])
  await computed(page)
  assert.match(await page.textContent('#bar .machine .small'), /not calibrated · ±8 %$/)
  assert.ok(await page.isVisible('#results .range'))
  // At a tolerance at which nobody has measured there is no range, and the bar says so.
  await page.click('#results .others button:has-text("20 µm")')
  assert.ok(await page.isHidden('#results .range'))
  assert.match(await page.textContent('#bar .machine .small'), /accuracy unknown/)
})
