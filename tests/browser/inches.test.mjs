// Lengths, feedrates and tolerances in inches: in the chart, its table and readings, on the path and in the tables; documents keep mm.

import assert from 'node:assert/strict'
import { readFileSync } from 'node:fs'
import { computed, frame, longTest, pageTest } from './steps.mjs'

/** One corner of 90°, far from both ends: each curve takes its whole tolerance there. */
const CORNER = { name: 'corner.nc', mimeType: 'text/plain', buffer: Buffer.from('G21 G90\nG1 X100 F3000\nG1 Y100\n') }
const MM_PER_INCH = 25.4

const tableRows = (page) => page.$$eval('#chart .behind tbody tr', (all) => all.map(({ cells }) => [...cells].map((cell) => cell.textContent)))
const tableHead = (page) => page.$$eval('#chart .behind thead th', (all) => all.map(({ textContent }) => textContent))
const numbers = (text) => (text.replaceAll(',', '').match(/\d+(\.\d+)?/g) ?? []).map(Number)

/** The largest difference of numbers in inches from those in mm. */
const difference = (mm, inches) => Math.max(...mm.map((value, index) => Math.abs(value / MM_PER_INCH - inches[index])))

/** Returns the reading in the middle of the chart, at the corner. */
async function reading(page) {
  await page.focus('#chart .plot')
  await page.keyboard.press('Shift+ArrowRight')
  await page.keyboard.press('Shift+ArrowLeft')
  const head = await page.textContent('#chart .reading strong')
  const curves = await page.$$eval('#chart .reading tr', (all) => all.map(({ cells }) => [...cells].map((cell) => cell.textContent)))
  return { head, curves }
}

/** The text of a file that a button saves. */
async function saved(page, button) {
  const [download] = await Promise.all([page.waitForEvent('download'), page.click(button)])
  return readFileSync(await download.path(), 'utf8')
}

/** Shows lengths in another unit, and waits until the table behind the chart has it. */
async function choose(page, word, symbol) {
  await page.selectOption('#length-unit', word)
  await page.waitForFunction((title) => document.querySelector('#chart .behind thead th').textContent === title, `Distance (${symbol})`)
  await frame(page)
}

async function opened(page) {
  await page.setInputFiles('#files', CORNER)
  await computed(page)
  await page.click('#chart .behind summary')
  await page.waitForSelector('#chart .behind tbody tr')
}

pageTest('the chart, its table and its readings are in inches, and undo brings mm back', async ({ page }) => {
  await opened(page)
  const before = { rows: await tableRows(page), ...(await reading(page)) }
  await choose(page, 'inch', 'in')

  const head = await tableHead(page)
  assert.deepEqual([head[0], head[2], head[3]], ['Distance (in)', 'CAM estimate (in/min)', '0.00039 in (in/min)'])
  const rows = await tableRows(page)
  assert.equal(rows.length, before.rows.length)
  for (const [index, [place, , programmed]] of rows.entries()) {
    const [placeBefore, , programmedBefore] = before.rows[index]
    assert.ok(difference(numbers(placeBefore), numbers(place)) <= 0.01, `${placeBefore} mm, ${place} in`)
    assert.ok(difference(numbers(programmedBefore), numbers(programmed)) <= 0.1, `${programmedBefore} mm/min, ${programmed} in/min`)
  }

  const after = await reading(page)
  assert.match(after.head, /^\d\.\d{3} in$/)
  assert.ok(difference(numbers(before.head), numbers(after.head)) <= 0.001, `${before.head}, ${after.head}`)
  assert.deepEqual(
    after.curves.map(([label, , error]) => [label, error]),
    ['0.00039', '0.00079', '0.00197'].map((tolerance) => [`${tolerance} in`, `${tolerance} in off`]),
  )
  for (const [index, [, feedrate]] of after.curves.entries()) {
    assert.match(feedrate, /^[\d,]+\.\d in\/min/)
    const [mean] = numbers(feedrate)
    // The columns of pixels over which a mean is taken move with the width of the numbers at the axis, and feedrates change fast here.
    assert.ok(difference([numbers(before.curves[index][1])[0]], [mean]) <= 0.2 * mean, `${before.curves[index][1]}, ${feedrate}`)
  }

  const words = (await saved(page, '#chart .picture >> nth=0')).match(/(?<=>)[^<]+/g).map((word) => word.trim())
  // A panel as low as these shortens its title to the unit.
  for (const title of ['in/min', 'Distance along the path (in)', 'in']) assert.ok(words.includes(title), title)
  assert.ok(words.includes('100'), 'the ticks of the feedrates are round in in/min')
  const quote = await saved(page, '#quote .html')
  assert.match(quote, /Feedrate \(mm\/min\)/)
  assert.doesNotMatch(quote, /in\/min|0\.00039/)

  await page.click('#history .undo-change')
  await page.waitForFunction(() => document.querySelector('#chart .behind thead th').textContent === 'Distance (mm)')
  assert.deepEqual(await tableRows(page), before.rows)
})

pageTest('a tolerance is typed in the unit that the field names, or with its own, and a change of unit empties the field', async ({ page }) => {
  const input = page.locator('#tolerances form input')
  const labels = () => page.$$eval('#tolerances .chip .label', (all) => all.map(({ textContent }) => textContent))
  const add = async (text) => {
    await input.fill(text)
    await input.press('Enter')
    return page.textContent('#tolerances .fault')
  }
  await opened(page)
  await page.click('#bar .tolerance')
  assert.equal(await input.getAttribute('placeholder'), 'add µm')
  await input.fill('0.5')
  await choose(page, 'inch', 'in')
  assert.deepEqual([await input.inputValue(), await input.getAttribute('placeholder')], ['', 'add in'])
  assert.equal(await input.getAttribute('aria-label'), 'Add a contour tolerance (in)')
  assert.equal(await add('0.0005'), '')
  assert.equal(await add('3 thou'), '')
  assert.deepEqual(await labels(), ['0.00039 in', '0.0005 in', '0.00079 in', '0.00197 in', '0.003 in'])
  assert.equal(await add('0.00039'), '0.00039 in is there already.')
  assert.match(await add('15'), /^15 in is out of range: .* 0\.3937 in/)

  await input.fill('0.002')
  await page.click('#history .undo-change')
  assert.equal(await input.inputValue(), '0.002', 'a change of anything but the unit leaves the field alone')
  await page.click('#history .undo-change')
  await page.click('#history .undo-change')
  assert.deepEqual([await input.inputValue(), await input.getAttribute('placeholder')], ['', 'add µm'])
  assert.equal(await add('12.7'), '')
  assert.deepEqual(await labels(), ['10 µm', '12.7 µm', '20 µm', '50 µm'])
})

longTest('tolerances, places and lengths are in inches on the rest of the page, also after a reload', async ({ page }) => {
  await opened(page)
  await page.check('#tolerances input[value="20 µm"]')
  await choose(page, 'inch', 'in')
  const labels = ['0.00039 in', '0.00079 in', '0.00197 in']
  const shown = async () => {
    assert.deepEqual(await page.$$eval('#tolerances .chip .label', (all) => all.map(({ textContent }) => textContent)), labels)
    assert.deepEqual(await page.$$eval('#tolerances .deviation', (all) => all.map(({ textContent }) => textContent)), labels)
    assert.equal(await page.textContent('#bar .tolerance .name'), labels[1], 'the tolerance that is quoted stays')
    assert.deepEqual(await page.$$eval('#path .at option', (all) => all.map(({ textContent }) => textContent)), labels)
    await page.locator('#path .places').scrollIntoViewIfNeeded()
    await page.waitForFunction(() => document.querySelector('#path .places tbody')?.textContent.includes('90° corner at 0.00079 in'))
    assert.match(await page.textContent('#path .legend'), /118\.1 in\/min/)
    assert.match(await page.textContent('#path .scale'), /^\d*\.?\d+ in$/)
    assert.match(await page.textContent('#breakdown .parts'), /7\.874 in/)
  }
  await shown()
  await page.reload()
  await page.waitForSelector('html[data-ready]')
  await computed(page)
  assert.equal(await page.inputValue('#length-unit'), 'inch')
  await shown()
  await page.selectOption('#length-unit', 'metric')
  assert.equal(await page.textContent('#bar .tolerance .name'), '20 µm')
})
