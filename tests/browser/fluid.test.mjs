// How soon the first chart of a long program is there, and whether zooming and panning ever hold the page up. The times
// are printed and not judged, since tests run on machines that do other things as well.

import assert from 'node:assert/strict'
import { computed, frame, pageTest } from './steps.mjs'

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

/**
 * The longest task of the page during what is done, ms: as the clock saw it, and what the processor worked in any, which is the page's
 * own share where the machine does other things as well.
 */
async function longestTask(page, body) {
  const browser = page.context().browser()
  await browser.startTracing(page, { categories: ['toplevel'] })
  // The start of a trace keeps the browser busy itself.
  await page.waitForTimeout(300)
  await body()
  await frame(page)
  await page.waitForTimeout(200)
  const { traceEvents: events } = JSON.parse(String(await browser.stopTracing()))
  const place = (/** @type {{ pid: number, tid: number }} */ { pid, tid }) => `${pid} ${tid}`
  const mains = new Set(events.filter(({ name, args }) => name === 'thread_name' && args.name === 'CrRendererMain').map(place))
  const tasks = events.filter((event) => event.ph === 'X' && event.name.endsWith('RunTask') && mains.has(place(event)))
  assert.ok(tasks.length > 0, 'tasks of the page are seen')
  const longest = (/** @type {string} */ key) => Math.max(...tasks.map((task) => task[key] ?? 0)) / 1000
  return { clock: longest('dur'), processor: longest('tdur') }
}

pageTest(`a program of ${LINES} lines is drawn soon, and its chart and path stay fluid`, async ({ page }) => {
  // From the drop to the first curve, seen by the page itself.
  const first = await page.evaluate(async (text) => {
    const data = new DataTransfer()
    data.items.add(new File([text], 'surface.nc'))
    const start = performance.now()
    document.body.dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }))
    const until = async (there) => {
      while (!there()) await new Promise((done) => setTimeout(done, 5))
      await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))
      return performance.now() - start
    }
    const chart = await until(() => document.querySelector('#chart .plot').dataset.span)
    const curve = await until(() => document.querySelector('#results data'))
    return { chart, curve }
  }, surface(LINES))
  await computed(page)
  const ms = (/** @type {number} */ value) => `${Math.round(value)} ms`
  console.log(`# first chart ${ms(first.chart)}, first curve ${ms(first.curve)} after the drop`)
  assert.ok(first.chart <= first.curve, 'what is programmed is drawn before it is simulated')

  for (const selector of ['#chart .plot', '#path .space']) {
    await page.locator(selector).scrollIntoViewIfNeeded()
    const { x, y, width, height } = await page.locator(selector).boundingBox()
    const picture = () => page.$eval(`${selector} canvas`, (canvas) => canvas.toDataURL())
    /** What rests is drawn finer than the page's own pixels. */
    const rests = async () =>
      page.waitForFunction((canvas) => canvas.width > canvas.clientWidth, await page.$(`${selector} canvas`))
    await rests()
    const whole = await picture()
    await page.$eval(`${selector} canvas`, (canvas) => {
      window.coarsest = Infinity
      // Asked for now: asking in a frame makes the browser lay out the page, which would be measured with it.
      const shown = canvas.clientWidth
      const note = () => (window.coarsest = Math.min(window.coarsest, canvas.width / shown))
      new MutationObserver(note).observe(canvas, { attributeFilter: ['width'] })
    })
    const { clock, processor } = await longestTask(page, async () => {
      await page.mouse.move(x + 0.6 * width, y + 0.3 * height)
      for (let turn = 0; turn < 12; turn += 1) await page.mouse.wheel(0, -240)
      await page.keyboard.down('Shift')
      await page.mouse.down()
      for (let step = 1; step <= 12; step += 1) await page.mouse.move(x + (0.6 - 0.02 * step) * width, y + 0.3 * height)
      await page.mouse.up()
      await page.keyboard.up('Shift')
      for (let turn = 0; turn < 6; turn += 1) await page.mouse.wheel(0, 240)
    })
    console.log(`# ${selector}: the longest task while zooming and moving takes ${ms(clock)}, ${ms(processor)} of a processor`)
    assert.notEqual(await picture(), whole, 'zooming and moving show something else')
    assert.equal(await page.evaluate(() => window.coarsest), 1, 'what moves is drawn no finer than the page')
    await rests()
  }
})
