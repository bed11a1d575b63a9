// Tolerances and machines side by side: the numbers of the command line, the curve over the tolerance, both axes of the
// chart, and every change taken back.

import assert from 'node:assert/strict'
import { join } from 'node:path'
import { binary, computed, frame, longTest, machineOf, pageTest, predicted, reach, ROOT, shot } from './steps.mjs'

const SAMPLE = join(ROOT, 'www/samples/pocket.nc')

const row = (page, title) =>
  page.$$eval(
    '#compare .columns tbody tr',
    (rows, title) => {
      const found = rows.find((row) => row.querySelector('th').textContent === title)
      return [...found.querySelectorAll('td')].map((cell) => cell.textContent)
    },
    title,
  )
const curveDone = (page) => page.waitForFunction(() => document.querySelector('#compare .stop').hidden, null, { timeout: 60_000 })
const number = (text) => Number(text.replaceAll(/[^\d.−-]/g, '').replace('−', '-'))
const chips = (page) => page.$$eval('.chip .label', (all) => all.map(({ textContent }) => textContent))

pageTest('tolerances stand side by side, on another machine as well, with the times of the command line', async ({ page }) => {
  await page.setInputFiles('#files', SAMPLE)
  await computed(page)
  const { runs } = await predicted(page, SAMPLE)
  const times = runs.map((run) => run.cycle_time_s)
  assert.deepEqual(
    (await row(page, 'In seconds')).map(number),
    times.map((time) => Number(time.toFixed(1))),
  )
  const differences = (await row(page, 'Difference')).slice(1).map(number)
  differences.forEach((shown, index) => assert.ok(Math.abs(shown - (times[index + 1] - times[0])) <= 0.051))
  const parts = (await row(page, 'Difference in %')).slice(1).map(number)
  parts.forEach((shown, index) => assert.ok(Math.abs(shown - 100 * (times[index + 1] / times[0] - 1)) <= 0.051))

  await page.selectOption('#compare .beside', { label: 'Vertical machining centre, mid-range' })
  await page.waitForFunction(() => !document.querySelector('#compare .columns').textContent.includes('…'))
  const both = (await row(page, 'In seconds')).map(number)
  assert.equal(both.length, 6)
  // The same machine in the form has the same times.
  await page.selectOption('#preset', { label: 'Vertical machining centre, mid-range' })
  await computed(page)
  const own = (await row(page, 'In seconds')).map(number)
  assert.deepEqual(own.slice(0, 3), both.slice(3))
  assert.deepEqual(own.slice(3), both.slice(3))
})

longTest('the curve over the tolerance falls to the programmed time, and a click on it adds a tolerance', async ({ page }) => {
  await page.setInputFiles('#files', SAMPLE)
  await computed(page)
  await curveDone(page)
  await page.click('#compare details summary')
  const points = await page.$$eval('#compare .points tbody tr', (rows) => rows.map((row) => [...row.children].map((cell) => cell.textContent)))
  assert.equal(points.length, 24)
  assert.deepEqual([points[0][0], points[23][0]], ['1.0 µm', '1000.0 µm'])
  const times = points.map(([, time]) => number(time))
  assert.ok(
    times.every((time, index) => index === 0 || time <= times[index - 1] + 0.051),
    `${times}`,
  )
  assert.ok(times[0] > 1.2 * times[23])
  const machine = await machineOf(page)
  assert.ok(machine && binary())
  const { runs } = await predicted(page, SAMPLE, [0.001, 1])
  assert.deepEqual(
    runs.map((run) => Number(run.cycle_time_s.toFixed(1))),
    [times[0], times[23]],
  )

  const before = await chips(page)
  const { width, height } = await page.locator('#compare .curve').boundingBox()
  await page.click('#compare .curve', { position: { x: width / 2, y: height / 2 } })
  await computed(page)
  const after = await chips(page)
  assert.equal(after.length, before.length + 1)
  // The dots have the colours of the chips.
  await frame(page)
  const dots = await page.evaluate(() => {
    const canvas = document.querySelector('#compare canvas')
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height)
    return [...document.querySelectorAll('.chip .swatch')].map((swatch) => {
      const wanted = getComputedStyle(swatch).backgroundColor.match(/\d+/g).map(Number)
      let count = 0
      for (let i = 0; i < data.length; i += 4) if (wanted.every((value, k) => Math.abs(data[i + k] - value) <= 2)) count += 1
      return count
    })
  })
  assert.ok(
    dots.every((count) => count > 100),
    `${dots}`,
  )

  await page.focus('#compare .curve')
  await page.keyboard.press('ArrowRight')
  await page.keyboard.press('ArrowRight')
  await page.keyboard.press('Enter')
  await computed(page)
  assert.equal((await chips(page)).length, before.length + 2)
  await shot(page, 'compare-1280')
})

longTest('the computation of the curve can be stopped and gone on with', async ({ page }) => {
  const lines = ['G21 G90 G94', 'G0 X0 Y0 Z0', 'F3000']
  for (let i = 1; i <= 60_000; i += 1) lines.push(`G1 X${(i * 0.1).toFixed(3)} Y${(Math.sin(i) * 0.2).toFixed(3)}`)
  // A panel that is opened for the first time compares with another machine, which begins the curve anew: it is open before.
  await page.setInputFiles('#files', SAMPLE)
  await computed(page)
  await reach(page, '#compare .stop')
  await curveDone(page)
  // A click from outside may arrive when the curve is whole, so the page itself clicks as soon as it offers to stop.
  await page.evaluate(() => {
    const stop = document.querySelector('#compare .stop')
    const observer = new MutationObserver(() => {
      if (stop.hidden || stop.closest('.bare, .stale')) return
      observer.disconnect()
      stop.click()
    })
    observer.observe(document.querySelector('#compare'), { attributes: true, subtree: true })
  })
  await page.setInputFiles('#files', { name: 'long.nc', mimeType: 'text/plain', buffer: Buffer.from(lines.join('\n')) })
  await page.waitForFunction(() => document.querySelector('#compare .standing').textContent === 'Stopped.')
  await computed(page)
  const missing = () => page.$$eval('#compare .points td', (cells) => cells.filter((cell) => cell.textContent === '…').length)
  const left = await missing()
  assert.ok(left > 0)
  await page.waitForTimeout(1000)
  assert.equal(await missing(), left)
  await page.click('#compare .stop')
  await curveDone(page)
  assert.equal(await missing(), 0)
})

pageTest('over time every curve ends with its cycle time; the cursor stays at its place of the path', async ({ page }) => {
  await page.setInputFiles('#files', SAMPLE)
  await computed(page)
  const [, length] = (await page.getAttribute('#chart .plot', 'data-span')).split(' ').map(Number)
  await page.selectOption('#chart .over', 'time')
  await frame(page)
  const [, timed] = (await page.getAttribute('#chart .plot', 'data-span')).split(' ').map(Number)
  assert.ok(Math.abs(timed - length) < 1e-6 * length, 'the whole path is in sight')
  const { x, y, width } = await page.locator('#chart .plot').boundingBox()
  await page.mouse.move(x + 0.5 * width, y + 120)
  const read = () => page.textContent('#chart .reading strong')
  const place = await read()
  await page.check('#chart .stack')
  await frame(page)
  assert.equal(await read(), place)
  // The curves are one below the other.
  const rows = await page.evaluate(() => {
    const canvas = document.querySelector('#chart canvas')
    const { width, height } = canvas
    const { data } = canvas.getContext('2d').getImageData(0, 0, width, Math.round(0.7 * height))
    return [...document.querySelectorAll('.chip .swatch')].map((swatch) => {
      const wanted = getComputedStyle(swatch).backgroundColor.match(/\d+/g).map(Number)
      let [count, sum] = [0, 0]
      // Without the legend.
      for (let i = 4 * width * 80; i < data.length; i += 4) {
        if (wanted.some((value, k) => Math.abs(data[i + k] - value) > 2)) continue
        count += 1
        sum += Math.floor(i / 4 / width)
      }
      return sum / count
    })
  })
  assert.ok(rows[0] < rows[1] && rows[1] < rows[2], `${rows}`)
  await page.focus('#chart .plot')
  await page.keyboard.press('+')
  await frame(page)
  const [from, to] = (await page.getAttribute('#chart .plot', 'data-span')).split(' ').map(Number)
  assert.ok(0 <= from && from < to && to - from < length)
  await shot(page, 'over-time-stacked-1280')
})

pageTest('every change is taken back and made again, and what was removed is computed again', async ({ page }) => {
  await page.setInputFiles('#files', SAMPLE)
  await computed(page)
  const table = () => page.textContent('#tolerances tbody')
  const first = await table()
  await page.click('.chip button >> nth=1')
  await computed(page)
  assert.deepEqual(await chips(page), ['10 µm', '50 µm'])
  await page.fill('#field-interpolator-time_constant_s', '0.05')
  await computed(page)
  assert.notEqual(await table(), first)
  await page.focus('.programs .choose')
  await page.keyboard.press('Delete')
  await page.waitForSelector('#welcome', { state: 'visible' })

  await page.keyboard.press('Control+z')
  await page.waitForSelector('.programs .choose')
  // What was computed of it went with it, and is computed again.
  await computed(page)
  assert.equal((await page.$$('#tolerances data')).length, 2)
  await page.click('#history .undo-change')
  await page.click('#history .undo-change')
  await computed(page)
  assert.equal(await table(), first)
  await page.keyboard.press('Control+Shift+z')
  await computed(page)
  assert.deepEqual(await chips(page), ['10 µm', '50 µm'])
})

pageTest('programs are tabs that the arrows move through', async ({ page }) => {
  await page.setInputFiles('#files', [SAMPLE, join(ROOT, 'www/samples/standin.nc')])
  await page.waitForFunction(() => document.querySelectorAll('.choose').length === 2)
  const tabs = () => page.$$eval('[role=tab]', (all) => all.map((tab) => tab.getAttribute('aria-selected')))
  await page.focus('[role=tab][aria-selected=true]')
  const before = await tabs()
  await page.keyboard.press('ArrowDown')
  const after = await tabs()
  assert.deepEqual(after, [...before].reverse())
  await page.keyboard.press('Home')
  assert.deepEqual(await tabs(), ['true', 'false'])
  await computed(page)
})
