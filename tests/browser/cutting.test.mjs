// Cutting forces on the page: closed and idle at first, on request as the command line says, and what is wrong is said.

import assert from 'node:assert/strict'
import { execFileSync } from 'node:child_process'
import { rmSync, writeFileSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after } from 'node:test'
import { binary, computed, frame, longTest, machineOf, pageTest, shot } from './steps.mjs'

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
  const rows = await page.$$eval('#cutting .result tbody tr', (all) => all.map((row) => [...row.cells].map((cell) => cell.textContent)))
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
  assert.match(await page.textContent('#cutting .result'), /the cutting job has no stock/)
  await compute(page, TEXT.replace('teeth', 'teth'))
  assert.match(await page.textContent('#cutting .fault'), /line 8, column 1: unknown field `teth`/)
})

/** Draws a surface of `count` short lines. */
function raster(count) {
  const rows = 100
  const each = Math.floor(count / rows)
  const lines = ['G21 G90', 'T1 M6', 'S12000 M3', '(RASTER)', 'G0 X0 Y0 Z5', 'G1 Z-1 F1000']
  for (let row = 0; row < rows; row += 1)
    for (let step = 0; step < each; step += 1) {
      const way = (100 * step) / (each - 1)
      const x = row % 2 ? 100 - way : way
      const z = -2 + Math.sin(x / 8) * Math.cos(row / 9)
      lines.push(`X${x.toFixed(4)} Y${row} Z${z.toFixed(4)} F2500`)
    }
  return `${lines.join('\n')}\nG0 Z5\nM30\n`
}

longTest('peaks lead to the chart and the program, and operations gain volume and power', async ({ page }) => {
  await page.setInputFiles('#files', PROGRAM)
  await computed(page)
  const span = () => page.$eval('#chart .plot', (plot) => plot.dataset.span.split(' ').map(Number))
  const titles = () => page.$$eval('#breakdown .parts thead th', (all) => all.map((title) => title.textContent))
  assert.ok(!(await titles()).some((title) => title.includes('Peak')), 'nothing before it is asked for')
  await page.click('#cutting summary')
  await compute(page, TEXT.replace('max_force_n = 100', 'max_force_n = 2000'))
  const whole = await span()
  const first = page.locator('#cutting .result tbody tr').first().locator('button').first()
  const line = Number(await first.textContent())
  assert.match(await first.getAttribute('title'), /X30 F1500|Y30|X-10/)
  await first.click()
  await page.waitForFunction((before) => document.querySelector('#chart .plot').dataset.span !== before, whole.join(' '))
  const [from, to] = await span()
  assert.ok(to - from < 0.5 * (whole[1] - whole[0]), `${from} to ${to}`)
  const { runs } = JSON.parse(execFileSync(binary(), ['predict', PROGRAM, '--machine', await machineOf(page), '--cutting', JOB, '--tolerance', '0.01', '--json'], { encoding: 'utf8' }))
  const peak = runs[0].cutting.programmed.force_n
  assert.equal(line, peak.line)
  assert.ok(from <= peak.distance_mm && peak.distance_mm <= to)

  // The same numbers stand in the breakdown at the tolerance of the cut, and only there.
  const cells = () => page.$$eval('#breakdown .parts tbody tr:first-child td', (all) => all.map((cell) => cell.textContent))
  const [removed, power] = [runs[0].operations[0].cutting.removed_mm3, runs[0].operations[0].cutting.peak_power_w.value]
  assert.deepEqual((await titles()).slice(-3), ['Removed (mm³)', 'Peak power (W)', 'Peak force (N)'])
  const [volume, watts] = (await cells()).slice(-3).map((text) => Number(text.replace(/,/g, '')))
  assert.ok(Math.abs(volume - removed) <= 0.51 && Math.abs(watts - power) <= 0.51, `${volume} ${watts}`)
  await page.selectOption('#breakdown select', { index: 1 })
  assert.ok(!(await titles()).some((title) => title.includes('Peak')))

  // A job in which nothing comes near its limits could be faster.
  const caption = page.locator('#cutting caption', { hasText: 'Where the feedrate could be higher' })
  assert.equal(await caption.count(), 1)
  assert.match(await page.textContent('#cutting .result'), /could be.*× [123]/is)
  await page.hover('#cutting .loads', { position: { x: 400, y: 200 } })
  assert.match(await page.textContent('#cutting .reading'), /Force.* N.*Power.* W.*line \d+/)
  await page.locator('#cutting .result').scrollIntoViewIfNeeded()
  await shot(page, 'cutting-peaks')
  await page.locator('#breakdown').scrollIntoViewIfNeeded()
  await shot(page, 'cutting-breakdown')

  // The sources of all coefficients are there, and which are not checked.
  await page.click('#cutting .materials summary')
  assert.match(await page.textContent('#cutting .materials'), /al7075.*Duan.*ti6al4v.*unchecked/s)
  await compute(page, TEXT.replace('al7075', 'c45'))
  assert.match(await page.textContent('#cutting .result li:last-child, #cutting .result'), /are not checked/)
})

longTest('a program of 20 000 lines does not block the page, tells its progress and can be stopped', async ({ page }) => {
  const text = raster(20_000)
  assert.ok(text.split('\n').length > 20_000)
  await page.setInputFiles('#files', { name: 'raster.nc', mimeType: 'text/plain', buffer: Buffer.from(text) })
  await computed(page)
  await page.click('#cutting summary')
  const job = TEXT.replace('resolution_mm = 0.2', '').replace('max_mm = [40, 40, 0]', 'max_mm = [100, 100, 0]')
  await page.fill('#cutting textarea', job)
  await page.click('#cutting .compute')
  await page.waitForFunction(() => document.querySelector('#cutting progress').value > 0.15)
  await shot(page, 'cutting-progress')
  await page.click('#cutting .cancel')
  await page.waitForSelector('#cutting .working', { state: 'hidden' })
  assert.equal(await page.$('#cutting .result table'), null)
  assert.equal(await page.textContent('#cutting .fault'), '')

  // What the page itself does with the result does not grow with the program: the worker computes, and a picture has as many
  // strokes as its pixels take.
  await page.evaluate(() => {
    window.strokes = { most: 0, own: 0 }
    const { lineTo } = CanvasRenderingContext2D.prototype
    Object.assign(CanvasRenderingContext2D.prototype, {
      lineTo(...to) {
        window.strokes.most = Math.max(window.strokes.most, (window.strokes.own += 1))
        return lineTo.apply(this, to)
      },
    })
    const { getContext } = HTMLCanvasElement.prototype
    HTMLCanvasElement.prototype.getContext = function (...given) {
      window.strokes.own = 0
      return getContext.apply(this, given)
    }
  })
  await page.click('#cutting .compute')
  await page.waitForSelector('#cutting .result table', { timeout: 120_000 })
  await page.locator('#cutting .loads').scrollIntoViewIfNeeded()
  await frame(page)
  const { strokes, pixels, elements } = await page.evaluate(() => ({
    strokes: window.strokes.most,
    pixels: document.querySelector('#cutting canvas').width,
    elements: document.querySelectorAll('#cutting *').length,
  }))
  // Three panels of two curves, each from its least to its largest value in a column.
  assert.ok(0 < strokes && strokes <= 3 * 2 * 4 * pixels, `${strokes} strokes on ${pixels} columns of pixels`)
  assert.ok(elements < 1000, `${elements} elements`)
  await shot(page, 'cutting-raster')
})

const DESCRIBED = join(tmpdir(), `truefeed-described-${process.pid}.nc`)
writeFileSync(DESCRIBED, '(T5 D=10. - FLAT END MILL|H5|STOCK - 0.2)\nG21 G90\nT5 M6\nS8000 M3\nG0 X-10 Y10 Z5\nZ-4\nG1 X30 F1500\nY30 F60\nX-10 F6000\nG0 Z5\nM30\n')
after(() => rmSync(DESCRIBED))

pageTest('a cutting job is a form: tools from the comments, the stock from the path, and teeth that rub or are overloaded are shown', async ({ page }) => {
  await page.setInputFiles('#files', DESCRIBED)
  await computed(page)
  await page.click('#more [aria-controls="cutting"]')
  const tool = page.locator('#cutting .entries tr:has(th:text-is("T5"))')
  await tool.waitFor()
  assert.match(await tool.textContent(), /FLAT END MILL$/, 'the name ends at the bar')
  const entry = (title) => page.locator(`#cutting .entries [aria-label="T5 ${title}"]`)
  assert.equal(await entry('Diameter (mm)').inputValue(), '10')
  assert.equal(await page.locator('#cutting .entries [aria-label="Stock Z to"]').inputValue(), '0')
  await page.click('#cutting .compute')
  assert.match(await page.textContent('#cutting .fault'), /Enter diameter and teeth of T5/)
  await entry('Teeth').fill('2')
  await entry('Overload above (mm per tooth)').fill('0.2')
  await page.click('#cutting .compute')
  await page.waitForSelector('#cutting .result caption:text-is("Feed per tooth at the predicted feedrate")')
  const cells = await page.$$eval('#cutting .result table:has(caption:text-is("Feed per tooth at the predicted feedrate")) tbody td', (all) => all.map(({ textContent }) => textContent))
  // F1500 at 8000 rpm and two teeth is 0.094 mm, F60 is 0.004 mm, F6000 is 0.375 mm.
  assert.ok(Number(cells[0]) > 0.3, `${cells}`)
  assert.ok(Number.parseFloat(cells[1]) > 5 && Number.parseFloat(cells[2]) > 5, `rubs ${cells[1]}, overloads ${cells[2]}`)
  const before = await page.getAttribute('#chart .plot', 'data-span')
  await page.click('#cutting .result button[title*="overloaded"]')
  await page.waitForFunction((before) => document.querySelector('#chart .plot').dataset.span !== before, before)
  await page.selectOption('#path .by', 'fed')
  assert.match(await page.textContent('#path .legend'), /rubbing.*overload/)
  // The text is the same job, and takes its place once it is edited.
  await page.click('#cutting .as-text summary')
  const text = await page.inputValue('#cutting textarea')
  assert.match(text, /\[tools\.5\] {2}# .*FLAT END MILL\ndiameter_mm = 10\nteeth = 2\nmax_chip_mm = 0\.2\n/)
  await page.fill('#cutting textarea', text.replace('teeth = 2', 'teeth = 3'))
  assert.ok(await page.$eval('#cutting .entries', (entries) => entries.inert))
  await page.click('#cutting .form button:has-text("Back to the form")')
  assert.match(await page.inputValue('#cutting textarea'), /teeth = 2/)
  await shot(page, 'cutting-form')
})
