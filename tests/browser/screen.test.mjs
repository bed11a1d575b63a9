// One screen, one answer: how few gestures lead from dropped programs to a price, how few stops by Tab, and that no figure is in
// sight twice.

import assert from 'node:assert/strict'
import { existsSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after, test } from 'node:test'
import { ROOT, atEverySize, computed, drop, frame, longTest, pageTest, shot } from './steps.mjs'

const SAMPLE = join(ROOT, 'www/samples/pocket.nc')
const STANDIN = join(ROOT, 'www/samples/standin.nc')
/** A real program of more than 2,000 blocks. */
const REAL = join(ROOT, '../shared/gcode/fanuc_haas/easy_gcode_plo__PARALLEL.NC')
const scratch = mkdtempSync(join(tmpdir(), 'truefeed-screen-'))
after(() => rmSync(scratch, { recursive: true }))
const MOST_GESTURES = 6
const MOST_STOPS = 40
const MOST_LINES = 400

/** The colour that a pixel of a canvas has, and that of the card it stands on. */
const groundAndCard = (page) =>
  page.$eval('#chart .plot canvas', (canvas) => {
    const [red, green, blue] = canvas.getContext('2d').getImageData(1, 1, 1, 1).data
    return [`rgb(${red}, ${green}, ${blue})`, getComputedStyle(canvas.closest('section')).backgroundColor]
  })

/** Counts what a user does: clicks, and fields that are filled. */
function counted(page) {
  const done = { gestures: 0 }
  return {
    done,
    click: async (selector) => {
      done.gestures += 1
      await page.click(selector)
    },
    type: async (text) => {
      done.gestures += 1
      await page.keyboard.type(text)
    },
  }
}

const priced = (page) => page.waitForFunction(() => /€\d/.test(document.querySelector('#quote .headline')?.textContent ?? ''))

longTest('from dropped programs to the price of 25 parts are at most six gestures', async ({ page }) => {
  await drop(page, 'main', [SAMPLE, STANDIN])
  await computed(page)
  const { done, click, type } = counted(page)
  await click('#quote .answer a')
  await type('85')
  await click('#term-quantity')
  await page.keyboard.press('Control+a')
  await type('25')
  await priced(page)
  assert.match(await page.textContent('#quote .of'), /^25 parts$/)
  assert.ok(done.gestures <= MOST_GESTURES, `${done.gestures} gestures`)
  // What it lacks is said beside it.
  assert.match(await page.textContent('#quote .lacking'), /Not in the price yet: set-up, load and unload, operator’s rate, material.*, margin/)
  await shot(page, 'price-1280')
})

pageTest('fewer than forty stops by Tab lead from the drop to a price, without any skipping', async ({ page }) => {
  await drop(page, 'main', [SAMPLE])
  await computed(page)
  await page.evaluate(() => document.activeElement.blur())
  let stops = 0
  while (!(await page.evaluate(() => document.activeElement.id === 'term-rates-hourly'))) {
    await page.keyboard.press('Tab')
    stops += 1
    assert.ok(stops < MOST_STOPS, `${stops} stops`)
  }
  await page.keyboard.type('85')
  await priced(page)
})

pageTest('a link skips to the price', async ({ page }) => {
  await drop(page, 'main', [SAMPLE])
  await computed(page)
  await page.keyboard.press('Tab')
  await page.keyboard.press('Tab')
  assert.ok(await page.isVisible('.skip a:focus'))
  await page.keyboard.press('Enter')
  await page.keyboard.press('Tab')
  assert.ok(await page.evaluate(() => document.activeElement.closest('#quote') !== null))
})

/** Times and amounts of money in sight on the first screen; the list of programs has each program's own, and a clock its end. */
const figures = (page) =>
  page.evaluate(() => {
    const walker = document.createTreeWalker(document.querySelector('main'), NodeFilter.SHOW_TEXT)
    const found = []
    for (let node = walker.nextNode(); node; node = walker.nextNode()) {
      const { parentElement: element } = node
      if (!element.checkVisibility() || element.closest('.programs, .drawer, .listing, .clock')) continue
      found.push(...(node.textContent.match(/\d+:\d\d:\d\d|\d[\d,]*\.\d+ s\b|€[\d,]+\.\d+/g) ?? []))
    }
    return found
  })

longTest('no time and no amount is in sight twice', async ({ page }) => {
  await drop(page, 'main', [existsSync(REAL) ? REAL : SAMPLE])
  await computed(page)
  await page.fill('#term-rates-hourly', '85')
  await priced(page)
  const all = await figures(page)
  assert.ok(all.length >= 4, `${all}`)
  assert.deepEqual(
    all.filter((figure, index) => all.indexOf(figure) !== index),
    [],
  )
  await atEverySize(page, 'screen')
})

pageTest(
  'at 1280 × 800 the answer, the picture, the timeline and the price are in sight at once',
  async ({ page }) => {
    await drop(page, 'main', [SAMPLE])
    await computed(page)
    await frame(page)
    for (const selector of ['#results .time', '#path .space', '#chart .plot', '#quote .answer']) {
      const { top, bottom } = await page.$eval(selector, (element) => element.getBoundingClientRect().toJSON())
      assert.ok(0 <= top && bottom <= 800, `${selector} is at ${top} to ${bottom}`)
    }
    await page.mouse.move(640, 780)
    await page.evaluate(() => scrollTo(0, document.body.scrollHeight))
    for (const selector of ['#bar', '#quote .answer']) {
      const { top } = await page.$eval(selector, (element) => element.getBoundingClientRect().toJSON())
      assert.ok(0 <= top && top < 400, `${selector} scrolls away`)
    }
  },
  { viewport: { width: 1280, height: 800 } },
)

/** What of the text of these elements is cut off. */
const cut = (page, selector) =>
  page.$$eval(selector, (all) =>
    all.filter((element) => element.checkVisibility() && (element.scrollWidth > element.clientWidth + 1 || element.scrollHeight > element.clientHeight + 1)).map(({ textContent }) => textContent),
  )

pageTest('titles of operations, what is in doubt and the machine are not cut off', async ({ page }) => {
  const programs = ['10', '20', '30'].map((number) => join(ROOT, `www/samples/bracket-${number}.nc`))
  const doubtful = join(scratch, 'doubtful.nc')
  writeFileSync(doubtful, 'G21 G90\nG61\nG28 Z0\nG0 X0 Y0\nG64 P0.03\nG1 X50 F600\nY50\nG28 X0\nM30\n')
  await drop(page, 'main', [...programs, doubtful])
  await page.waitForFunction(() => document.querySelectorAll('#program .choose .about').length === 4 && /\d:\d\d/.test(document.querySelector('#program .total')?.textContent))
  assert.equal(await page.locator('#program .choose').count(), 4)
  assert.deepEqual(await cut(page, '#program .choose .file'), [])
  await page.click('#program li:has-text("doubtful") .choose')
  assert.match(await page.textContent('#results .doubt'), /up to .* s/)
  assert.deepEqual(await cut(page, '#results .doubt p'), [])
  assert.match(await page.textContent('#bar .tolerance .name'), /as programmed/)
  await page.setViewportSize({ width: 390, height: 844 })
  const { width } = await page.$eval('#bar .machine .name', (element) => element.getBoundingClientRect().toJSON())
  assert.ok(40 <= width, `the machine has ${width} px of a phone`)
})

longTest('the whole in small takes the colours of the theme', async ({ page }) => {
  await page.emulateMedia({ colorScheme: 'light' })
  await drop(page, 'main', [SAMPLE])
  await computed(page)
  await frame(page)
  /** How light it is on the whole, 0 to 255. */
  const lightness = () =>
    page.$eval('#chart .overview canvas', (canvas) => {
      const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height)
      return data.reduce((sum, value, index) => sum + (index % 4 < 3 ? value : 0), 0) / (0.75 * data.length)
    })
  const light = await lightness()
  await page.emulateMedia({ colorScheme: 'dark' })
  await frame(page)
  assert.ok((await lightness()) < 0.5 * light, `${await lightness()} in the dark, ${light} in the light`)
})

longTest('charts have the ground of the card that they stand on, in both themes', async ({ page }) => {
  await drop(page, 'main', [SAMPLE])
  await computed(page)
  for (const colorScheme of ['light', 'dark']) {
    await page.emulateMedia({ colorScheme })
    await frame(page)
    const [ground, card] = await groundAndCard(page)
    assert.equal(ground, card)
  }
})

pageTest('what opens goes away by Escape and by ×, and gives the focus back', async ({ page }) => {
  await drop(page, 'main', [SAMPLE])
  await computed(page)
  const focused = () => page.evaluate(() => document.activeElement.getAttribute('popovertarget') ?? document.activeElement.getAttribute('aria-controls'))
  for (const id of ['machine', 'tolerances', 'settings']) {
    await page.locator(`.pick[popovertarget="${id}"]`).click()
    assert.ok(await page.isVisible(`#${id}`))
    await page.keyboard.press('Tab')
    await page.keyboard.press('Escape')
    assert.ok(await page.isHidden(`#${id}`))
    assert.equal(await focused(), id)
  }
  for (const id of ['breakdown', 'compare']) {
    await page.locator(`#more [aria-controls="${id}"]`).click()
    assert.ok(await page.isVisible(`#${id}`))
    assert.ok((await page.$eval(`#${id}`, (element) => element.getBoundingClientRect().top)) < 800, 'it is brought in sight')
    await page.focus('#opened > .close')
    await page.keyboard.press(id === 'breakdown' ? 'Escape' : 'Enter')
    assert.ok(await page.isHidden(`#${id}`))
    assert.equal(await focused(), id)
  }
})

pageTest(
  'an answer on a phone comes first, then the picture, the timeline, the operations, the price',
  async ({ page }) => {
    await drop(page, 'main', [SAMPLE])
    await computed(page)
    const tops = await page.$$eval('#results, #path, #chart, #program, #quote', (all) => all.map((element) => [element.id, element.getBoundingClientRect().top + scrollY]))
    const order = tops.sort(([, a], [, b]) => a - b).map(([id]) => id)
    assert.deepEqual(order, ['results', 'path', 'chart', 'program', 'quote'])
    const small = await page.$$eval('a[href]:not(.skip a), button, .button, select, summary, input:not([type="file"])', (all) =>
      all
        .filter((element) => element.checkVisibility())
        .flatMap((element) => {
          const { width, height } = element.getBoundingClientRect()
          const label = element.matches('[type="radio"], [type="checkbox"]') && element.closest('label')
          return label || Math.min(width, height) >= 24 ? [] : [`${element.outerHTML.slice(0, 80)}: ${width} × ${height}`]
        }),
    )
    assert.deepEqual(small, [])
    // Below it the answer goes along in the bar, and only there.
    assert.ok(await page.isHidden('header .answer'))
    await page.$eval('#quote', (quote) => quote.scrollIntoView())
    await page.waitForSelector('header .answer:not([hidden])')
    assert.equal(await page.textContent('header .answer'), await page.textContent('#results .time'))
    for (const id of ['jobs', 'settings'])
      assert.ok((await page.$eval(`header > [popovertarget=${id}]`, (button) => Number.parseFloat(getComputedStyle(button).fontSize))) > 9, 'a symbol has its word')
  },
  { viewport: { width: 390, height: 844 } },
)

longTest('the demo diagnoses by itself and ends at the diagnosis', async ({ page }) => {
  await page.click('#welcome .concealed')
  await page.waitForFunction(() => /longer than simulated/.test(document.querySelector('#diagnosis .sentence').textContent), null, { timeout: 180_000 })
  assert.ok(await page.isVisible('#diagnosis .account'))
  await page.waitForFunction(() => Math.abs(document.querySelector('#diagnosis').getBoundingClientRect().top - 60) < 80)
  const top = await page.$eval('#diagnosis', (element) => element.getBoundingClientRect().top)
  assert.ok(0 <= top && top < 140, `the diagnosis is at ${top}`)
  // Where it acts is behind a click, and shown in the charts.
  const before = await page.getAttribute('#chart .plot', 'data-span')
  await page.click('#diagnosis .lines summary')
  await page.click('#diagnosis .lines button')
  await page.waitForFunction((before) => document.querySelector('#diagnosis .plot').dataset.span !== before, before)
  await shot(page, 'demo-1280')
})

test('no module of the page is longer than 400 lines', () => {
  const modules = readdirSync(join(ROOT, 'www'), { recursive: true }).filter((name) => /\.(js|css|html)$/.test(name) && !/^pkg|\.css$/.test(name))
  assert.ok(modules.length > 50)
  const long = modules.map((name) => [name, readFileSync(join(ROOT, 'www', name), 'utf8').split('\n').length - 1]).filter(([, lines]) => lines > MOST_LINES)
  assert.deepEqual(long, [])
})
