// Cutting forces on the page: closed and idle at first, on request as the command line says, and what is wrong is said.

import assert from 'node:assert/strict'
import { execFileSync } from 'node:child_process'
import { rmSync, writeFileSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after } from 'node:test'
import { binary, computed, machineOf, pageTest, shot } from './steps.mjs'

const PROGRAM = join(tmpdir(), `truefeed-cutting-${process.pid}.nc`)
const JOB = join(tmpdir(), `truefeed-cutting-${process.pid}.toml`)
const TEXT = `material = "al7075"
resolution_mm = 0.2
[stock]
min_mm = [0, 0, -10]
max_mm = [40, 40, 0]
[tool]
diameter_mm = 10
teeth = 2
helix_deg = 30
max_force_n = 100
`
writeFileSync(PROGRAM, 'G21 G90\nS8000 M3\nG0 X-10 Y10 Z5\nZ-4\nG1 X30 F1500\nY30\nX-10\nG0 Z5\nM30\n')
writeFileSync(JOB, TEXT)
after(() => [PROGRAM, JOB].forEach((path) => rmSync(path)))

const compute = async (page, job) => {
  await page.fill('#cutting textarea', job)
  await page.click('#cutting .compute')
  await page.waitForSelector('#cutting .result table, #cutting .result li, #cutting .fault:not(:empty)')
}

pageTest('cutting forces are computed on request, as on the command line', async ({ page }) => {
  await page.setInputFiles('#files', PROGRAM)
  await computed(page)
  assert.equal(await page.isVisible('#cutting textarea'), false, 'closed at first')
  await page.click('#cutting summary')
  await compute(page, TEXT)

  const machine = await machineOf(page)
  const options = ['predict', PROGRAM, '--machine', machine, '--cutting', JOB, '--tolerance', '0.01', '--json']
  const { runs, diagnostics } = JSON.parse(execFileSync(binary(), options, { encoding: 'utf8' }))
  const { programmed, predicted } = runs[0].cutting
  const rows = await page.$$eval('#cutting tbody tr', (all) =>
    all.map((row) => [...row.cells].map((cell) => cell.textContent)),
  )
  assert.equal(rows[0][0], 'Force (N)')
  assert.equal(rows[0][2], String(programmed.force_n.line))
  assert.ok(Math.abs(Number(rows[0][1]) - programmed.force_n.value) < 0.051, rows[0][1])
  assert.ok(Math.abs(Number(rows[0][3]) - predicted.force_n.value) < 0.051, rows[0][3])
  const remarks = await page.$$eval('#cutting li', (all) => all.map((item) => item.textContent))
  assert.equal(remarks.length, 1)
  assert.ok(remarks[0].endsWith(diagnostics.find(({ message }) => message.includes('force on the tool')).message))
  const drawn = await page.$eval('#cutting canvas', (canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height)
    return new Set(new Uint32Array(data.buffer)).size
  })
  assert.ok(drawn > 5, `${drawn} colours`)
  await page.locator('#cutting').scrollIntoViewIfNeeded()
  await shot(page, 'cutting')

  await compute(page, TEXT.replace(/\[stock\]\n.*\n.*\n/, ''))
  assert.match(await page.textContent('#cutting .result'), /the stock is not given/)
  await compute(page, TEXT.replace('teeth', 'teth'))
  assert.match(await page.textContent('#cutting .fault'), /line 8, column 1: unknown field `teth`/)
})
