// The page says where the time goes, as the command line does, and leads from an operation to its place in the chart.

import assert from 'node:assert/strict'
import { rmSync, writeFileSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after } from 'node:test'
import { atEverySize, computed, pageTest, predicted, span, TOLERANCES_MM } from './steps.mjs'

const PROGRAM = join(tmpdir(), `truefeed-operations-${process.pid}.nc`)
writeFileSync(
  PROGRAM,
  [
    'G21 G90',
    'T1 M6',
    'S6000 M3',
    'M8',
    'G0 X0 Y0',
    ...Array.from({ length: 40 }, (_, i) => `G1 X${i + 1} Y${i % 2} F3000`),
    'M9',
    'M5',
    'T12 M6',
    'S9000 M3',
    'G0 Z5',
    'G1 X80 F1500',
    'G4 X2.',
    'M0',
    'M5',
    'M30',
  ].join('\n'),
)
after(() => rmSync(PROGRAM))

const text = (page, selector) => page.$$eval(selector, (all) => all.map((element) => element.textContent.replace(/\s+/g, ' ').trim()))
/** Rows of a table as lists of cells. */
const rows = (page, selector) => page.$$eval(`${selector} tbody tr`, (all) => all.map((row) => [...row.cells].map((cell) => cell.textContent)))
const shown = (seconds) => `${seconds.toFixed(1)} s`

async function set(page, key, value) {
  await page.evaluate(() => (document.querySelector('#machine details').open = true))
  await page.fill(`#field-${key.replaceAll('.', '-')}`, value)
}

pageTest('operations, tools and machine functions are shown', async ({ page }) => {
  await page.setInputFiles('#files', PROGRAM)
  await computed(page)
  assert.deepEqual(
    (await rows(page, '#breakdown .kinds')).map(([kind]) => kind),
    ['Cutting', 'Rapid', 'Dwell', 'Tool changes'],
    'functions that take no time are left out',
  )
  await set(page, 'times.spindle_start_s', '1.5')
  await set(page, 'times.spindle_s_per_1000_rpm', '0.2')
  await set(page, 'times.coolant_on_s', '2')
  await set(page, 'times.program_stop_s', '30')
  await set(page, 'times.tools', 'T12 = 9')
  await page.waitForSelector('.stale')
  await computed(page)

  const { runs } = await predicted(page, PROGRAM)
  const kinds = await rows(page, '#breakdown .kinds')
  assert.deepEqual(
    kinds.map(([kind]) => kind),
    ['Cutting', 'Rapid', 'Dwell', 'Tool changes', 'Spindle', 'Coolant', 'Program stops'],
  )
  const expected = runs.map(({ breakdown: { other } }) => shown(other.spindle_s))
  assert.deepEqual(kinds[4].slice(1), expected)
  // Two starts and two stops: 6000 and 9000 rpm up and down.
  assert.ok(Math.abs(runs[0].breakdown.other.spindle_s - (2 * 1.5 + 2 * 15 * 0.2)) < 1e-9)
  assert.equal(runs[0].breakdown.tool_change_s, 4 + 9)

  for (const [index] of TOLERANCES_MM.entries()) {
    await page.selectOption('#breakdown select', { index })
    const { operations, tools } = runs[index]
    const [byOperation, byTool] = [1, 2].map((n) => `#breakdown .parts > :nth-child(${n})`)
    const found = await rows(page, byOperation)
    assert.deepEqual(
      found.map(([line, name, time]) => [line, name, time]),
      operations.map(({ line, tool, time_s }) => [String(line), tool === null ? 'Before the first tool' : `T${tool}`, shown(time_s)]),
    )
    assert.deepEqual(
      (await rows(page, byTool)).map(([tool, , time]) => [tool, time]),
      tools.map(({ tool, time_s }) => [tool === null ? 'None named' : `T${tool}`, shown(time_s)]),
    )
    const sum = operations.reduce((total, { time_s }) => total + time_s, 0)
    assert.ok(Math.abs(sum - runs[index].cycle_time_s) < 1e-9)
  }
  assert.deepEqual(await text(page, '#breakdown caption'), ['Operations', 'Tools'])

  await page.locator('#breakdown').scrollIntoViewIfNeeded()
  await atEverySize(page, 'breakdown')
  const { distance_mm: place } = runs[0].operations.at(-1)
  await page.focus('#breakdown .parts tbody tr:last-child button')
  await page.keyboard.press('Enter')
  const [from, to] = await span(page)
  assert.ok(from <= place[0] && place[1] <= to * (1 + 1e-9), `${from} to ${to} mm, not ${place}`)
  assert.ok(0 < from, 'only the operation is shown')
})
