// Charts that tell: curves of long programs are lines that can be told apart, can be hidden, and stand under their tools; the wheel
// scrolls, and the whole in small leads to every part.

import assert from 'node:assert/strict'
import { atEverySize, computed, frame, longTest, pageTest, shot, span } from './steps.mjs'

/** Programs of more than 2,000 blocks, of four kinds in five forms each. */
function programs() {
  const head = 'G21 G90 G94\nG0 X0 Y0 Z5\nG1 Z0 F1200\n'
  const kinds = {
    surface: (k, form) => {
      const [row, column] = [Math.floor(k / 90), k % 90]
      const x = (0.2 + 0.1 * form) * (row % 2 ? 89 - column : column)
      return `G1 X${x.toFixed(3)} Y${(0.4 * row).toFixed(2)} Z${((1 + form) * Math.sin(0.3 * x)).toFixed(3)} F${2000 + 300 * form}`
    },
    corners: (k, form) => {
      const x = (Math.floor((k + 1) / 2) % 2) * (1 + form + (Math.floor(k / 2) % 7))
      return `G1 X${x} Y${(0.5 * Math.floor(k / 2)).toFixed(2)} F3000`
    },
    loops: (k, form) => `G3 X${(0.6 * (k + 1) + 2 * (k % 2)).toFixed(2)} Y0 I${(1 + 0.1 * (k % 5)).toFixed(2)} J${(0.1 * form).toFixed(1)} F2500`,
    chords: (k, form) => {
      const turn = (0.06 + 0.01 * form) * k
      return `G1 X${((3 + 0.02 * turn) * Math.cos(turn)).toFixed(3)} Y${((3 + 0.02 * turn) * Math.sin((1 + 0.2 * form) * turn)).toFixed(3)} F4000`
    },
  }
  return Object.entries(kinds).flatMap(([kind, line]) =>
    [1, 2, 3, 4, 5].map((form) => {
      const lines = Array.from({ length: 2200 }, (_, k) => line(k, form))
      return { name: `${kind}-${form}.nc`, mimeType: 'text/plain', buffer: Buffer.from(head + lines.join('\n')) }
    }),
  )
}

/** A program of two tools and three operations. */
const TOOLS = {
  name: 'tools.nc',
  mimeType: 'text/plain',
  buffer: Buffer.from(
    `G21 G90 G94\n(ROUGHING)\nT1 M6\nG0 X0 Y0 Z5\nG1 Z-2 F600\n${Array.from({ length: 60 }, (_, k) => `G1 X${(k % 2) * 40} Y${k} F2000`).join('\n')}\nG0 Z5\n(FINISHING)\nT2 M6\nG0 X0 Y0\nG1 Z-3 F600\nG1 X60 F1500\nG1 Y60\nG1 X0\nG1 Y0\nG0 Z5\nM30\n`,
  ),
}

/** For each colour of the curves and each column of the picture of feedrates: the rows that have it, and the share of all pixels. */
const drawn = (page) =>
  page.evaluate(() => {
    const canvas = document.querySelector('#chart .plot canvas')
    const { width, height } = canvas
    const ratio = width / canvas.clientWidth
    const { data } = canvas.getContext('2d').getImageData(0, 0, width, height)
    const colors = [0, 1, 2].map((index) => getComputedStyle(document.documentElement).getPropertyValue(`--curve-${index}`).match(/\d+/g).map(Number))
    const bottom = Math.round(0.57 * height)
    const [left, right] = [Math.round(70 * ratio), width - Math.round(40 * ratio)]
    const rows = colors.map(() => [])
    let inked = 0
    for (let x = left; x < right; x += 1) {
      const own = colors.map(() => [])
      for (let y = 0; y < bottom; y += 1) {
        const at = 4 * (y * width + x)
        const index = colors.findIndex((color) => color.every((value, channel) => Math.abs(data[at + channel] - value) <= 3))
        if (index >= 0) own[index].push(y)
        inked += index >= 0 ? 1 : 0
      }
      own.forEach((list, index) => rows[index].push(list.length > 0 ? [list[0], list.at(-1)] : null))
    }
    return { rows, share: inked / ((right - left) * bottom), height: bottom }
  })

const toggle = (page, index) => page.click(`#chart .curves button >> nth=${index + 1}`)

longTest('curves of twenty long programs are lines that can be traced and told apart', async ({ page }) => {
  const all = programs()
  assert.equal(all.length, 20)
  await page.setInputFiles('#files', all)
  for (const [index, { name }] of all.entries()) {
    await page.click(`.choose >> nth=${index}`)
    await computed(page)
    await frame(page)
    await page.waitForTimeout(200)
    await frame(page)
    const whole = await drawn(page)
    if (index % 5 === 0) await page.locator('#chart').screenshot({ path: new URL(`output/charts-${name}.png`, import.meta.url).pathname })
    assert.ok(whole.share <= 0.25, `${name}: ink on ${whole.share} of the plot`)
    const alone = []
    for (const curve of [0, 1, 2]) {
      for (const other of [0, 1, 2]) if (other !== curve) await toggle(page, other)
      await frame(page)
      const { rows } = await drawn(page)
      const there = rows[curve].filter(Boolean).length / rows[curve].length
      assert.ok(0.95 <= there, `${name}: curve ${curve} over ${there} of the width`)
      alone.push(rows[curve])
      for (const other of [0, 1, 2]) if (other !== curve) await toggle(page, other)
    }
    await frame(page)
    // Where two differ by a tenth of the axis, each is seen.
    let [apart, seen] = [0, 0]
    for (const [a, b] of [
      [0, 1],
      [0, 2],
      [1, 2],
    ])
      alone[a].forEach((rows, x) => {
        const other = alone[b][x]
        if (!rows || !other) return
        const far = Math.max(other[0] - rows[1], rows[0] - other[1])
        if (far < 0.1 * whole.height) return
        apart += 1
        seen += whole.rows[a][x] && whole.rows[b][x] ? 1 : 0
      })
    assert.ok(apart === 0 || 0.95 <= seen / apart, `${name}: ${seen} of ${apart} places told apart`)
  }
})

pageTest('the wheel scrolls the page, and zooms with Ctrl; the first turn says so', async ({ page }) => {
  await page.click('#welcome .sample')
  await computed(page)
  for (const selector of ['#chart .plot', '#path .space']) {
    await page.locator(selector).evaluate((element) => element.scrollIntoView({ block: 'center' }))
    await page.waitForTimeout(300)
    await frame(page)
    const box = await page.locator(selector).boundingBox()
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2)
    const before = [await page.evaluate(() => scrollY), await span(page), await page.textContent('#path .scale')]
    await page.mouse.wheel(0, 120)
    await page.waitForFunction((y) => scrollY !== y, before[0])
    assert.deepEqual(await span(page), before[1])
    if (selector === '#chart .plot') assert.match(await page.textContent('.wheel-hint'), /Ctrl \+ wheel/)
    await page.locator(selector).evaluate((element) => element.scrollIntoView({ block: 'center' }))
    await page.keyboard.down('Control')
    await page.mouse.wheel(0, -400)
    await page.mouse.wheel(0, -400)
    await page.keyboard.up('Control')
    await frame(page)
    if (selector === '#chart .plot') assert.notDeepEqual(await span(page), before[1])
    else assert.notEqual(await page.textContent('#path .scale'), before[2])
  }
  assert.ok((await page.locator('.wheel-hint').count()) <= 1)
})

pageTest('curves are hidden and shown by their names, and the read-out says what is drawn', async ({ page }) => {
  const [program] = programs()
  await page.setInputFiles('#files', program)
  await computed(page)
  await frame(page)
  const box = await page.locator('#chart .plot').boundingBox()
  const names = await page.locator('#chart .curves button').allTextContents()
  assert.deepEqual(names, ['programmed', '10 µm', '20 µm', '50 µm'])
  await toggle(page, 1)
  assert.equal(await page.locator('#chart .curves button >> nth=2').getAttribute('aria-pressed'), 'false')
  await page.mouse.move(box.x + 0.6 * box.width, box.y + 0.3 * box.height)
  const rows = await page.locator('#chart .reading tr').allTextContents()
  assert.equal(rows.length, 2, 'what is hidden is not read')
  assert.match(rows[0], /10 µm.*mm\/min mean, [\d,]+–[\d,]+/)
  const { rows: colors } = await drawn(page)
  assert.ok(
    colors[1].every((column) => column === null),
    'the hidden curve is not drawn',
  )
  const [reading, plot] = [await page.locator('#chart .reading').boundingBox(), box]
  assert.ok(reading.width * reading.height < 0.25 * plot.width * plot.height, 'the read-out takes a corner')
  await shot(page, 'charts-read')
  await toggle(page, 1)
  // Zoomed in far enough, every sample is drawn.
  await page.focus('#chart .plot')
  for (let i = 0; i < 12; i += 1) await page.keyboard.press('+')
  await frame(page)
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.3 * box.height)
  assert.doesNotMatch((await page.locator('#chart .reading tr').allTextContents())[0], /mean/)
})

pageTest('tools and operations stand over the chart, and the whole in small below it', async ({ page }) => {
  await page.setInputFiles('#files', TOOLS)
  await computed(page)
  await frame(page)
  const bands = await page.$$eval('#chart .bands span', (all) => all.map(({ textContent, title, offsetWidth }) => ({ textContent, title, offsetWidth })))
  assert.equal(bands.length, 2)
  assert.match(bands[0].title, /^T1 .*ROUGHING/i)
  assert.match(bands[1].title, /^T2 .*FINISHING/i)
  const box = await page.locator('#chart .plot').boundingBox()
  await page.mouse.move(box.x + 0.3 * box.width, box.y + 0.3 * box.height)
  assert.match(await page.textContent('#chart .reading'), /T1 · ROUGHING/i)

  const whole = await span(page)
  const overview = await page.locator('#chart .overview').boundingBox()
  const at = (part) => [overview.x + part * overview.width, overview.y + overview.height / 2]
  // An end of the window, then the window itself.
  await page.mouse.move(...at(0.999))
  await page.mouse.down()
  await page.mouse.move(...at(0.5), { steps: 4 })
  await page.mouse.up()
  const half = await span(page)
  assert.ok(half[0] === whole[0] && Math.abs(half[1] / whole[1] - 0.5) < 0.02, `${half} of ${whole}`)
  await page.mouse.move(...at(0.25))
  await page.mouse.down()
  await page.mouse.move(...at(0.5), { steps: 4 })
  await page.mouse.up()
  const moved = await span(page)
  assert.ok(Math.abs(moved[0] / whole[1] - 0.25) < 0.02 && Math.abs(moved[1] / whole[1] - 0.75) < 0.02, `${moved}`)
  await page.click('#chart .ask')
  assert.ok(await page.isVisible('#chart .shortcuts'))
  assert.equal(await page.getAttribute('#chart .ask', 'aria-expanded'), 'true')
  await page.click('#chart .ask')
  await atEverySize(page, 'charts-tools')
})
