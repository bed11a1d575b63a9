// The path in space, the text beside it and the costliest places: drawn, linked with the charts, and fluid.

import assert from 'node:assert/strict'
import { readFileSync } from 'node:fs'
import { join } from 'node:path'
import { ROOT, computed, frame, longTest, pageTest, predicted, shot, span } from './steps.mjs'

const SAMPLE = join(ROOT, 'www/samples/pocket.nc')
const LINES = readFileSync(SAMPLE, 'utf8').split(/\r\n|\n|\r/)

/** Opens the sample with the path in sight. */
async function opened(page) {
  await page.click('#welcome .sample')
  await computed(page)
  await page.click('#path .show-text')
  await page.click('#path .costly summary')
  await page.locator('#path .space').evaluate((space) => space.scrollIntoView({ block: 'center' }))
  await page.waitForSelector('#path .places tbody tr')
  await rested(page)
}

/** Waits until the picture is drawn finely. */
async function rested(page) {
  await page.waitForTimeout(300)
  await frame(page)
}

/**
 * Returns the colours of the drawing, the centre of its pixels, and the pixel at a third of their list, in CSS pixels from the corner
 * of the canvas. The page computes them, because a list of more than a million pixels takes long to reach the test.
 */
const drawn = (page) =>
  page.$eval('#path canvas', (canvas) => {
    const { width, height } = canvas
    const { data } = canvas.getContext('2d').getImageData(0, 0, width, height)
    const ratio = width / canvas.clientWidth
    const inked = []
    const codes = new Set()
    let [x, y] = [0, 0]
    for (let i = 0; i < width * height; i += 1) {
      if (data[4 * i + 3] === 0) continue
      inked.push(i)
      codes.add((data[4 * i] << 16) | (data[4 * i + 1] << 8) | data[4 * i + 2])
      x += i % width
      y += Math.floor(i / width)
    }
    const third = inked[Math.floor(inked.length / 3)]
    return {
      colors: [...codes].map((code) => `${code >> 16} ${(code >> 8) & 255} ${code & 255}`),
      center: [x / inked.length / ratio, y / inked.length / ratio],
      third: { x: (third % width) / ratio, y: Math.floor(third / width) / ratio },
    }
  })

const colors = async (page) => new Set((await drawn(page)).colors)
const center = async (page) => (await drawn(page)).center
const legend = (page) => page.$$eval('#path .ramp span', (all) => all.map((swatch) => swatch.style.backgroundColor.match(/\d+/g).join(' ')))
/** The shades of which colours are, each faded to white by less than a half and darkened; undefined is of a colour that is of none. */
function litShades(found, shades) {
  const all = [...shades, RAPID].map((shade) => shade.split(' ').map(Number))
  const isOf = (color, shade) => {
    for (let fade = 0; fade <= 0.46; fade += 0.01) {
      const faded = shade.map((value) => value + fade * (255 - value))
      const dark = Math.min(...faded.map((value, channel) => (value > 8 ? color[channel] / value : 1)))
      if (0.44 <= dark && dark <= 1.02 && faded.every((value, channel) => Math.abs(dark * value - color[channel]) <= 3)) return true
    }
    return false
  }
  return new Set([...found].map((color) => all.find((shade) => isOf(color.split(' ').map(Number), shade))?.join(' ')))
}

/** The colour of rapids on light ground. */
const RAPID = '200 206 213'
const selectedLine = (page) => page.locator('#path [aria-selected="true"]').evaluate((line) => Number(line.dataset.line))

longTest('a click in the chart selects the line before the text was ever in sight', async ({ page }) => {
  await page.click('#welcome .sample')
  await computed(page)
  await frame(page)
  assert.ok(!(await page.isVisible('#path .listing')), 'the text is shown already')
  const { width, height } = await page.locator('#chart .plot').boundingBox()
  await page.click('#chart .plot', { position: { x: width / 2, y: height / 3 } })
  const line = await page.textContent('#chart .reading .code')
  await page.click('#path .show-text')
  await page.waitForSelector('#path [aria-selected="true"]')
  assert.match(line, new RegExp(`line ${await selectedLine(page)}\\b`))
})

for (const [width, height] of [
  [360, 780],
  [1280, 900],
  [2560, 1300],
]) {
  pageTest(
    `the path is drawn in the colours of its legend at ${width} px`,
    async ({ page }) => {
      await opened(page)
      const shades = await legend(page)
      assert.equal(new Set(shades).size, shades.length, 'every shade has its own colour')
      // Light fades and darkens a shade, and keeps its hue: each colour is one between a shade, the ground and black.
      const used = litShades(await colors(page), shades)
      assert.ok(3 <= used.size, `${used.size} shades`)
      assert.ok(!used.has(undefined), 'only shades and rapids')
      assert.match(await page.textContent('#path .legend'), /mm\/min/)
      const wider = await page.evaluate(() => document.documentElement.scrollWidth > innerWidth)
      assert.ok(!wider, 'the page scrolls sideways')
      for (const scheme of ['light', 'dark']) {
        await page.emulateMedia({ colorScheme: scheme })
        await rested(page)
        await page.locator('#path').screenshot({ path: join(ROOT, `tests/browser/output/path-${width}-${scheme}.png`) })
      }
      await page.click('#path [data-look="turned"]')
      await page.selectOption('#path .by', 'loss')
      await rested(page)
      assert.match(await page.textContent('#path .legend'), /0\.00 %.*100\.0 %/)
      await page.locator('#path').screenshot({ path: join(ROOT, `tests/browser/output/path-${width}-turned.png`) })
    },
    { viewport: { width, height }, isLong: width !== 1280 },
  )
}

longTest('the costliest places are those of the command line, and add up', async ({ page }) => {
  await opened(page)
  const { runs } = await predicted(page, SAMPLE)
  for (const [index, { lost }] of runs.entries()) {
    await page.selectOption('#path .at', { index })
    const shown = await page.$$eval('#path .places tbody tr', (rows) => rows.map((row) => [row.cells[1].textContent, row.cells[2].textContent]))
    assert.deepEqual(
      shown,
      lost.places.map(({ lines: [from, to], text }) => [from === to ? `${from}` : `${from}–${to}`, text]),
    )
    assert.equal(shown.length, 10)
    const sum = lost.places.reduce((total, { seconds }) => total + seconds, lost.elsewhere_s)
    assert.ok(Math.abs(sum - lost.seconds) < 1e-9)
    assert.ok(0 < lost.seconds && lost.seconds < runs[index].cycle_time_s)
    assert.equal(await page.locator('#path .marks span').count(), 10)
  }
})

pageTest('a place leads to its spot, its line and its stretch of the charts', async ({ page }) => {
  await opened(page)
  const { runs } = await predicted(page, SAMPLE)
  const place = runs[0].lost.places[2]
  await page.click('#path .places tbody tr:nth-child(3) button')
  await rested(page)
  assert.equal(await selectedLine(page), place.lines[0])
  const [from, to] = await span(page)
  assert.ok(from <= place.distance_mm[0] && place.distance_mm[1] <= to, `${from} to ${to} mm`)
  assert.ok(await page.isVisible('#path .here'))
  assert.ok(await page.isVisible('#chart .cross'))
  const mark = await page.$eval('#path .marks .chosen', (chosen) => [chosen.textContent, parseFloat(chosen.style.left), parseFloat(chosen.style.top)])
  assert.equal(mark[0], '3')
  const here = await page.$eval('#path .here', (dot) => [parseFloat(dot.style.left), parseFloat(dot.style.top)])
  assert.ok(Math.hypot(here[0] - mark[1], here[1] - mark[2]) < 1)
  await page.locator('#path').screenshot({ path: join(ROOT, 'tests/browser/output/path-place.png') })
})

longTest('a click selects a line even if the text is redrawn between press and release', async ({ page }) => {
  await opened(page)
  await page.locator('#path .listing').scrollIntoViewIfNeeded()
  const { x, y } = await page.locator('#path [data-line="3"]').boundingBox()
  await page.mouse.move(x + 20, y + 9)
  await page.mouse.down()
  await page.$eval('#path .listing', (listing) => listing.dispatchEvent(new Event('scroll')))
  await frame(page)
  await page.mouse.up()
  await frame(page)
  assert.equal(await selectedLine(page), 3)
})

pageTest('path, text and charts have one cursor', async ({ page }) => {
  await opened(page)
  const box = await page.locator('#path .space').boundingBox()
  // On the path, by pointer.
  const { x, y } = (await drawn(page)).third
  await page.mouse.move(box.x + x + 1, box.y + y + 1)
  await page.waitForSelector('#path .here')
  assert.ok(await page.isVisible('#chart .cross'))
  const here = await page.$eval('#path .here', (dot) => [parseFloat(dot.style.left), parseFloat(dot.style.top)])
  assert.ok(Math.hypot(here[0] - x, here[1] - y) < 10, `${here} for ${x} ${y}`)
  const [, number, text] = (await page.textContent('#path .reading .code')).match(/line (\d+) (.*)/)
  assert.equal(text, LINES[number - 1])
  await page.mouse.down()
  await page.mouse.up()
  await rested(page)
  assert.equal(await selectedLine(page), Number(number), 'a click selects the line')

  // On the text.
  await page.locator('#path .listing').evaluate((listing) => (listing.scrollTop = 0))
  await frame(page)
  const line = LINES.findIndex((code, index) => 12 < index && /X/.test(code)) + 1
  await page.click(`#path [data-line="${line}"]`)
  assert.equal(await selectedLine(page), line)
  assert.ok(await page.isVisible('#path .here'))
  const cross = await page.$eval('#chart .cross', (element) => element.style.left)

  // On the chart, by keys.
  await page.focus('#chart .plot')
  await page.keyboard.press('Shift+ArrowRight')
  assert.notEqual(await page.$eval('#chart .cross', (element) => element.style.left), cross)
  await page.locator('#path').scrollIntoViewIfNeeded()
  await rested(page)
  await page.keyboard.press('Shift+ArrowRight')
  await page.keyboard.press('Shift+ArrowRight')
  const said = Number((await page.textContent('#chart .reading .code')).match(/line (\d+)/)[1])
  assert.ok(await page.isVisible('#path .here'), 'the chart moves the spot on the path')
  await page.keyboard.press('Enter')
  await rested(page)
  assert.equal(await selectedLine(page), said, 'Enter in the chart selects the line')
})

pageTest('the view turns, moves and zooms by pointer and keys, and comes back', async ({ page }) => {
  await opened(page)
  assert.equal(await page.getAttribute('#path [data-look="turned"]', 'aria-pressed'), 'true', 'a part with depth is first seen obliquely')
  await page.click('#path [data-look="top"]')
  await rested(page)
  const whole = await center(page)
  // Smaller, so that nothing of it leaves the picture when it moves.
  await page.click('#path [data-do="out"]')
  await rested(page)
  const small = await center(page)
  const box = await page.locator('#path .space').boundingBox()
  await page.mouse.move(box.x + 200, box.y + 200)
  await page.mouse.down()
  await page.mouse.move(box.x + 240, box.y + 230, { steps: 4 })
  await page.mouse.up()
  await rested(page)
  const moved = await center(page)
  assert.ok(Math.abs(moved[0] - small[0] - 40) < 3 && Math.abs(moved[1] - small[1] - 30) < 3, `${small} to ${moved}`)
  const scale = () => page.$eval('#path .scale', (bar) => parseFloat(bar.textContent) / bar.clientWidth)
  const before = await scale()
  await page.keyboard.down('Control')
  for (let turn = 0; turn < 3; turn += 1) await page.mouse.wheel(0, -120)
  await page.keyboard.up('Control')
  await rested(page)
  assert.ok((await scale()) < 0.7 * before, 'the wheel zooms in')
  await page.focus('#path .space')
  await page.keyboard.press('Home')
  await rested(page)
  const back = await center(page)
  assert.ok(Math.hypot(back[0] - whole[0], back[1] - whole[1]) < 0.5, 'Home shows the whole again')
  const axes = () => page.$$eval('#path .axes span', (all) => all.map(({ textContent }) => textContent).join(''))
  assert.equal(await axes(), 'XY')
  await page.click('#path [data-look="front"]')
  await rested(page)
  assert.equal(await axes(), 'XZ')
  await page.click('#path [data-look="turned"]')
  await rested(page)
  assert.equal(await axes(), 'XYZ')
  const first = await center(page)
  await page.focus('#path .space')
  for (let i = 0; i < 4; i += 1) await page.keyboard.press('ArrowRight')
  await rested(page)
  assert.notDeepEqual(await center(page), first)
})

longTest('with a recording the path shows where time was lost', async ({ page }) => {
  await page.click('#welcome .sample')
  await computed(page)
  const choices = () => page.$$eval('#path .by option', (all) => all.map(({ value }) => value))
  assert.ok(!(await choices()).includes('lost'))
  await page.click('#more [aria-controls^="recording"]')
  await page.click('#recording .concealed')
  await page.waitForSelector('#recording .sentence:not(.refused)', { timeout: 120_000 })
  await computed(page)
  await page.locator('#path .space').evaluate((space) => space.scrollIntoView({ block: 'center' }))
  await page.selectOption('#path .by', 'lost')
  await rested(page)
  const ends = (await page.textContent('#path .legend')).match(/:-([\d.]+) s\/m([\d.]+) s\/m/)
  assert.ok(ends && 0 < Number(ends[1]) && ends[1] === ends[2], 'the scale has as much to lose as to gain')
  const shades = await legend(page)
  const found = litShades(await colors(page), shades)
  assert.ok(
    shades.slice(8).some((shade) => found.has(shade)),
    'time was lost somewhere',
  )
  await page.locator('#path').screenshot({ path: join(ROOT, 'tests/browser/output/path-lost.png') })
})

longTest('hundreds of thousands of blocks stay fluid', async ({ page }) => {
  const blocks = 300_000
  const lines = ['G21 G90 G94', 'G0 X0 Y0 Z5', 'F3000']
  for (let i = 0; i < blocks; i += 1) {
    const [row, column] = [Math.floor(i / 1000), i % 1000]
    const x = 0.2 * (row % 2 ? 999 - column : column)
    lines.push(`G1 X${x.toFixed(2)} Y${(row * 0.5).toFixed(2)} Z${(8 * Math.sin(x / 20) * Math.cos(row / 25)).toFixed(3)}`)
  }
  await page.setInputFiles('#files', { name: 'surface.nc', mimeType: 'text/plain', buffer: Buffer.from(lines.join('\n')) })
  await page.waitForSelector('html[data-whole]', { timeout: 170_000 })
  await page.click('#path .show-text')
  await page.locator('#path').scrollIntoViewIfNeeded()
  await page.waitForSelector('#path .places tbody tr', { state: 'attached', timeout: 100_000 })
  await page.waitForSelector('#progress', { state: 'hidden', timeout: 150_000 })
  await page.click('#path [data-look="turned"]')
  await rested(page)
  const rows = await page.locator('#path [role="option"]').count()
  assert.ok(rows < 100, `${rows} lines of ${blocks} are in the page`)
  await page.focus('#path .listing')
  await page.keyboard.press('End')
  await frame(page)
  assert.equal(await selectedLine(page), blocks + 3)

  // Each picture of the path, and the frames that there are room for.
  await page.evaluate(() => {
    Object.assign(window, { pictures: [], frames: 0 })
    const { putImageData } = CanvasRenderingContext2D.prototype
    CanvasRenderingContext2D.prototype.putImageData = function (image, ...at) {
      window.pictures.push(image.width * image.height)
      return putImageData.call(this, image, ...at)
    }
    const count = () => {
      window.frames += 1
      requestAnimationFrame(count)
    }
    requestAnimationFrame(count)
  })
  const box = await page.locator('#path .space').boundingBox()
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2)
  await page.mouse.down()
  for (let i = 1; i <= 30; i += 1) {
    await page.mouse.move(box.x + box.width / 2 + 4 * i, box.y + box.height / 2 + 2 * i)
    await frame(page)
  }
  await page.mouse.up()
  await page.keyboard.down('Control')
  for (let i = 0; i < 20; i += 1) {
    await page.mouse.wheel(0, -60)
    await frame(page)
  }
  await page.keyboard.up('Control')
  await rested(page)
  const { pictures, frames, area } = await page.evaluate(() => {
    const { clientWidth, clientHeight } = document.querySelector('#path .space canvas')
    return { pictures: window.pictures, frames: window.frames, area: clientWidth * clientHeight }
  })
  await shot(page, 'path-surface')
  // However often the pointer moves, no frame draws the path twice; while it moves a picture has the page's own pixels, and at
  // rest it has no more than a raster may have. How long one takes is for benches/browser.mjs to say.
  assert.ok(0 < pictures.length && pictures.length <= frames, `${pictures.length} pictures in ${frames} frames`)
  const [least, most] = [Math.min(...pictures), Math.max(...pictures)]
  assert.ok(least <= 1.01 * area && most <= 3.01e6, `pictures of ${least} to ${most} pixels on ${area} of the page`)
})

longTest('the program is played: tool, clock, text and chart go together, and pause', async ({ page }) => {
  await opened(page)
  const clock = () => page.textContent('#path .now')
  const seconds = async () => (await clock()).split(':').reduce((sum, part) => 60 * sum + Number(part), 0)
  const here = () => page.$eval('#path .here', (dot) => [parseFloat(dot.style.left), parseFloat(dot.style.top)])
  assert.equal(await clock(), '0:00:00', 'nothing plays by itself')
  await page.waitForTimeout(300)
  assert.equal(await clock(), '0:00:00')
  await page.selectOption('#path .player select', '60')
  await page.focus('#path .space')
  await page.keyboard.press('Space')
  await page.waitForFunction(() => document.querySelector('#path .now').textContent > '0:00:02')
  assert.equal(await page.getAttribute('#path .play', 'aria-label'), 'Pause')
  assert.ok(await page.isVisible('#chart .cross'), 'the chart follows')
  await page.keyboard.press('Space')
  const [at, spot, line] = [await clock(), await here(), await selectedLine(page)]
  await page.locator('#path').screenshot({ path: join(ROOT, 'tests/browser/output/path-played.png') })
  await page.waitForTimeout(200)
  assert.equal(await clock(), at, 'it pauses')
  assert.deepEqual(await here(), spot)
  assert.ok(3 < line, 'the text follows')

  // The slider leads to any moment, and time there is that of the motion.
  await page.$eval('#path .player input', (slider) => {
    slider.value = '500'
    slider.dispatchEvent(new Event('input'))
  })
  await frame(page)
  const { runs } = await predicted(page, SAMPLE)
  assert.ok(Math.abs((await seconds()) - runs[0].cycle_time_s / 2) <= 1)
  assert.notDeepEqual(await here(), spot)
  const pale = await colors(page)
  await page.selectOption('#path .player select', '')
  await page.click('#path .play')
  await page.waitForFunction(() => document.querySelector('#path .play').getAttribute('aria-label') === 'Play', undefined, { timeout: 60_000 })
  assert.ok(Math.abs((await seconds()) - runs[0].cycle_time_s) <= 1, 'it ends with the program')
  await rested(page)
  const whole = await colors(page)
  assert.ok(pale.size !== whole.size || [...pale].some((color) => !whole.has(color)), 'what is still to be run is pale')
})

pageTest('tools have colours of their own', async ({ page }) => {
  const tool = (number, x) => `(TOOL ${number})\nT${number} M6\nG0 X${x} Y0 Z5\nG1 Z-2 F600\nG1 X${x + 30} F2000\nG1 Y40\nG1 X${x}\nG1 Y0\nG0 Z5`
  const text = `G21 G90 G94\n${tool(1, 0)}\n${tool(2, 50)}\n${tool(3, 100)}\nM30\n`
  await page.setInputFiles('#files', { name: 'tools.nc', mimeType: 'text/plain', buffer: Buffer.from(text) })
  await computed(page)
  await page.locator('#path .space').evaluate((space) => space.scrollIntoView({ block: 'center' }))
  await page.waitForSelector('#path .places tbody tr', { state: 'attached' })
  await page.selectOption('#path .by', 'tool')
  await rested(page)
  const parts = await page.$$eval('#path .legend .part', (all) => all.map((part) => [part.textContent, part.querySelector('i').style.backgroundColor.match(/\d+/g).join(' ')]))
  assert.deepEqual(
    parts.map(([name]) => name.slice(0, 2)),
    ['T1', 'T2', 'T3'],
  )
  const used = litShades(
    await colors(page),
    parts.map(([, color]) => color),
  )
  assert.ok(parts.every(([, color]) => used.has(color)) && !used.has(undefined), `${[...used]}`)
  await page.locator('#path').screenshot({ path: join(ROOT, 'tests/browser/output/path-tools.png') })
})
