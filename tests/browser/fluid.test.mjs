// A long program is drawn before it is simulated, and what moves is drawn no finer than the page; how long that takes is for
// benches/browser.mjs to say.

import assert from 'node:assert/strict'
import { computed, frame, longTest } from './steps.mjs'

const LINES = 22_000

/** A finishing pass in short blocks over a wavy surface, with a feedrate of its own each row. */
function surface(lines) {
  const text = ['G21 G90 G94', 'G0 X0 Y0 Z5', 'S12000 M3', 'G1 Z0 F1200']
  for (let index = 0; text.length < lines - 1; index += 1) {
    const [row, column] = [Math.floor(index / 200), index % 200]
    const x = 0.4 * (row % 2 === 0 ? column : 199 - column)
    const z = 2 * Math.sin(0.11 * x) * Math.cos(0.05 * row)
    text.push(`G1 X${x.toFixed(3)} Y${(0.3 * row).toFixed(3)} Z${z.toFixed(3)}${column === 0 ? ` F${2500 + 10 * (row % 30)}` : ''}`)
  }
  return [...text, 'M30'].join('\n')
}

longTest(`a program of ${LINES} lines is drawn before it is simulated, and coarsely while chart or path move`, async ({ page }) => {
  // Seen by the page itself: whether a cycle time was there when the chart first showed a stretch.
  const wasSimulated = page.evaluate(
    (text) =>
      new Promise((done) => {
        const plot = document.querySelector('#chart .plot')
        const note = () => plot.dataset.span && done(document.querySelector('#tolerances data') !== null)
        new MutationObserver(note).observe(plot, { attributeFilter: ['data-span'] })
        const data = new DataTransfer()
        data.items.add(new File([text], 'surface.nc'))
        document.body.dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }))
      }),
    surface(LINES),
  )
  assert.equal(await wasSimulated, false, 'what is programmed is drawn before it is simulated')
  await computed(page)

  for (const selector of ['#chart .plot', '#path .space']) {
    await page.locator(selector).scrollIntoViewIfNeeded()
    const { x, y, width, height } = await page.locator(selector).boundingBox()
    const picture = () => page.$eval(`${selector} canvas`, (canvas) => canvas.toDataURL())
    /** What rests is drawn finer than the page's own pixels. */
    const rests = async () => page.waitForFunction((canvas) => canvas.width > canvas.clientWidth, await page.$(`${selector} canvas`))
    await rests()
    const whole = await picture()
    await page.$eval(`${selector} canvas`, (canvas) => {
      window.coarsest = Infinity
      // Asked for now: asking in a frame makes the browser lay out the page, which would be measured with it.
      const shown = canvas.clientWidth
      const note = () => (window.coarsest = Math.min(window.coarsest, canvas.width / shown))
      new MutationObserver(note).observe(canvas, { attributeFilter: ['width'] })
    })
    await page.mouse.move(x + 0.6 * width, y + 0.3 * height)
    await page.keyboard.down('Control')
    for (let turn = 0; turn < 12; turn += 1) await page.mouse.wheel(0, -240)
    await page.keyboard.up('Control')
    await page.keyboard.down('Shift')
    await page.mouse.down()
    for (let step = 1; step <= 12; step += 1) await page.mouse.move(x + (0.6 - 0.02 * step) * width, y + 0.3 * height)
    await page.mouse.up()
    await page.keyboard.up('Shift')
    await page.keyboard.down('Control')
    for (let turn = 0; turn < 6; turn += 1) await page.mouse.wheel(0, 240)
    await page.keyboard.up('Control')
    await frame(page)
    assert.notEqual(await picture(), whole, 'zooming and moving show something else')
    assert.equal(await page.evaluate(() => window.coarsest), 1, 'what moves is drawn no finer than the page')
    await rests()
  }
})
