// The page does its job in a real browser: programs in, the command line's cycle times out, curves on the canvas.

import assert from 'node:assert/strict'
import { existsSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { basename, dirname, join } from 'node:path'
import { assertAsPredicted, atEverySize, computed, cycleTimes, drop, frame, longTest, pageTest, pixelsOfCurves, predicted, ROOT, shot, span, TOLERANCES_MM, workersEnded } from './steps.mjs'

const SAMPLE = join(ROOT, 'www/samples/pocket.nc')
const REAL = [join(ROOT, '../shared/gcode/fanuc_haas/easy_gcode_plo__PARALLEL.NC'), join(ROOT, '../shared/recordings/nist-hurco/programs/box-op3.nc')]
/** The lower panel, as a part of the canvas. */
const CONTOUR_ERRORS_BELOW = 0.65
const WHOLE = '/pkg/truefeed_whole_bg.wasm'
const PHONE = { width: 390, height: 844 }

/** A program of many short blocks, which takes long enough to be cancelled. */
function longProgram(blocks) {
  const lines = ['G21 G90 G94', 'G0 X0 Y0 Z0', 'F3000']
  for (let i = 1; i <= blocks; i += 1) lines.push(`G1 X${(i * 0.1).toFixed(3)} Y${(Math.sin(i) * 0.2).toFixed(3)}`)
  return { name: 'long.nc', mimeType: 'text/plain', buffer: Buffer.from(lines.join('\n')) }
}

pageTest("the sample gives the command line's times and a curve of each colour", async ({ page }) => {
  await page.click('#welcome .sample')
  await computed(page)
  await assertAsPredicted(page, SAMPLE)
  await frame(page)
  const bottom = await page.$eval('.plot', (plot) => plot.getBoundingClientRect().bottom)
  assert.ok(bottom <= page.viewportSize().height, 'both panels are in sight without scrolling')
  await atEverySize(page, 'sample', async (name) => {
    const pixels = await pixelsOfCurves(page)
    assert.equal(pixels.length, TOLERANCES_MM.length)
    // The legend alone has about 50 pixels of a colour.
    assert.ok(
      pixels.every((count) => count > 80),
      `${name}, pixels of each curve: ${pixels}`,
    )
    const errors = await pixelsOfCurves(page, CONTOUR_ERRORS_BELOW)
    assert.ok(
      errors.every((count) => count > 200),
      `${name}, pixels of each curve's contour errors: ${errors}`,
    )
    await shot(page, name)
  })
})

for (const program of REAL) {
  const skip = existsSync(program) ? false : `${basename(program)} is not in ../shared; the recorded corpus provides it`
  pageTest(
    `${basename(program)} through the file input`,
    async ({ page }) => {
      await page.setInputFiles('#files', program)
      await computed(page)
      await assertAsPredicted(page, program)
      await frame(page)
      assert.ok((await pixelsOfCurves(page)).every((count) => count > 80))
      await shot(page, `${basename(program)}-1280`)
    },
    { skip },
  )

  longTest(
    `${basename(program)} dropped on the page`,
    async ({ page }) => {
      await drop(page, 'header', [program])
      await computed(page)
      await assertAsPredicted(page, program)
      await shot(page, `${basename(program)}-390`)
    },
    { skip, viewport: PHONE },
  )
}

// Neither goes straight on, so that the module of the first visit leaves them to the whole one.
const LOOP = ['%', 'O1 (STEPS)', '#1=3', 'WHILE [#1 GT 0] DO1', 'G1 X[#1*10.] F500.', 'Y[#1*4.]', '#1=#1-1', 'END1', 'M30', '%']
const KLARTEXT = ['0 BEGIN PGM STEPS MM', '1 L X+0 Y+0 R0 FMAX', '2 L X+30 F500', '3 L Y+20', '4 END PGM STEPS MM']
for (const [name, lines] of /** @type {[string, string[]][]} */ ([
  ['loop.nc', LOOP],
  ['steps.h', KLARTEXT],
])) {
  pageTest(`${name}, the first program of a visit, waits for the whole module and is quoted by it`, async ({ page, requests }) => {
    const program = join(mkdtempSync(join(tmpdir(), 'truefeed-left-')), name)
    writeFileSync(program, lines.join('\n'))
    assert.ok(!requests.some((url) => url.endsWith(WHOLE)), 'the whole module is there before it is needed')
    await page.setInputFiles('#files', program)
    await computed(page)
    await assertAsPredicted(page, program)
    assert.ok(requests.some((url) => url.endsWith(WHOLE)))
    rmSync(dirname(program), { recursive: true })
  })
}

pageTest('what is in doubt of a cycle time stands beside it, and why below', async ({ page }) => {
  const file = (/** @type {string} */ name, /** @type {string} */ text) => ({ name, mimeType: 'text/plain', buffer: Buffer.from(text) })
  await page.setInputFiles('#files', file('sure.nc', 'G21 G90\nG1 X50 F500\nY30'))
  await computed(page)
  assert.deepEqual([await page.$$('#results .unsure'), await page.textContent('#results .why')], [[], ''])
  await page.setInputFiles('#files', file('no-feed.nc', 'G21 G90\nG1 X50\nY30\nX0 F500\nY0'))
  await page.waitForSelector('#results .unsure')
  await computed(page)
  const beside = await page.$$eval('#results .unsure', (all) => all.map(({ textContent }) => textContent))
  assert.equal(beside.length, 1)
  assert.match(beside[0], /feedrate is missing, at line 2: up to [1-9][0-9.]* s$/)
  await shot(page, 'in-doubt')
})

pageTest('a bad program is answered line by line, and the rest is quoted', async ({ page }) => {
  const text = 'G21 G90\nG1 X10 F600\nG1 X\nG2 X20\nG1 X30 &?!\nG1 X40\n'
  await page.setInputFiles('#files', { name: 'bad.nc', mimeType: 'text/plain', buffer: Buffer.from(text) })
  await computed(page)
  // The lines are looked up in the file.
  await page.waitForFunction(() => [...document.querySelectorAll('#diagnostics tbody code')].every((code) => code.textContent !== ''))
  const remarks = await page.$$eval('#diagnostics tbody tr', (rows) =>
    rows.map((row) => ({
      line: Number(row.querySelector('.line').textContent),
      code: row.querySelector('code').textContent,
    })),
  )
  for (const line of [3, 4, 5]) {
    assert.ok(
      remarks.some((remark) => remark.line === line && remark.code === text.split('\n')[line - 1]),
      `nothing about line ${line}`,
    )
  }
  assert.match(await page.textContent('#diagnostics .counts'), /\d+ error/)
  assert.ok((await cycleTimes(page)).every((time) => time > 0))
  await shot(page, 'bad')

  await page.setInputFiles('#files', { name: 'letter.txt', mimeType: 'text/plain', buffer: Buffer.from('Dear Sir,\nthe part is late.\n') })
  await page.waitForFunction(() => document.querySelectorAll('.choose').length === 2)
  await page.waitForSelector('.moves-nothing #diagnostics tbody tr', { state: 'attached' })
})

pageTest('what is no program is named, with what to drop instead, and what is beside it is taken', async ({ page }) => {
  const noise = Buffer.from(Array.from({ length: 5000 }, (_, i) => (i * 7919) % 256))
  const file = (name, buffer) => ({ name, mimeType: 'application/octet-stream', buffer: Buffer.from(buffer) })
  const refused = '#notice .refused span'
  for (const [name, bytes, kind] of [
    ['noise.bin', noise, 'a binary file'],
    ['drawing.pdf', '%PDF-1.7\n', 'a PDF'],
    ['part.step', 'ISO-10303-21;\nHEADER;\n', 'a STEP model'],
  ]) {
    await page.setInputFiles('#files', file(name, bytes))
    await page.waitForFunction(({ refused, text }) => document.querySelector(refused).textContent.includes(text), { refused, text: `${name} seems to be ${kind}` })
    assert.match(await page.textContent(refused), /You can drop G-code programs/)
    assert.ok(await page.isVisible(refused))
  }
  assert.equal(await page.locator('.choose').count(), 0)
  await page.setInputFiles('#files', [file('part.zip', 'PK\x03\x04'), file('part.nc', 'G21 G90\nG1 X10 F600\n')])
  await computed(page)
  // Archives are unpacked; one that is cut off says so.
  assert.match(await page.textContent(refused), /part\.zip: .*a ZIP archive that is damaged/)
  assert.deepEqual(await page.$$eval('.choose .file', (all) => all.map(({ textContent }) => textContent)), ['part.nc'])
})

pageTest('the focus is never lost: it goes to the program that was added, and to Undo when the last one is removed', async ({ page }) => {
  const focused = () => page.evaluate(() => document.activeElement.className)
  await page.focus('#welcome .sample')
  await page.keyboard.press('Enter')
  await computed(page)
  assert.equal(await focused(), 'choose')
  await page.keyboard.press('Delete')
  await frame(page)
  assert.equal(await focused(), 'undo-change')
  await page.keyboard.press('Enter')
  await computed(page)
})

pageTest(
  'the page fits a phone at twice its size',
  async ({ page }) => {
    await page.click('#welcome .sample')
    await computed(page)
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), PHONE.width / 2)
  },
  { viewport: { width: PHONE.width / 2, height: PHONE.height / 2 } },
)

pageTest('two fingers magnify the chart about the place between them', async ({ page }) => {
  await page.click('#welcome .sample')
  await computed(page)
  const cdp = await page.context().newCDPSession(page)
  await cdp.send('Emulation.setTouchEmulationEnabled', { enabled: true, maxTouchPoints: 2 })
  const { x, y, width, height } = await page.locator('#chart .plot').boundingBox()
  const [from, to] = await span(page)
  const touch = (type, apart) => {
    const points = [-1, 1].map((side, id) => ({ x: x + width / 2 + side * apart, y: y + height / 3, id }))
    return cdp.send('Input.dispatchTouchEvent', { type, touchPoints: apart ? points : [] })
  }
  await touch('touchStart', 40)
  for (const apart of [60, 80, 100, 120]) await touch('touchMove', apart)
  await touch('touchEnd', 0)
  const [left, right] = await span(page)
  assert.ok(Math.abs((to - from) / (right - left) / 3 - 1) < 0.1, `${to - from} mm became ${right - left} mm`)
  assert.ok(from < left && right < to)
})

pageTest('cancelling ends the work and keeps what there was; the next run works', async ({ page }) => {
  await page.click('#welcome .sample')
  await computed(page)
  const before = await cycleTimes(page)
  await page.setInputFiles('#files', longProgram(400_000))
  await page.waitForSelector('#progress progress:visible')
  assert.match(await page.textContent('#progress p'), /long\.nc: /)
  await page.click('#progress button')
  await page.waitForFunction(() => document.querySelector('#progress p').textContent.startsWith('Cancelled'))
  assert.equal(await page.$$eval('.choose', (all) => all.length), 2)
  await workersEnded(page)

  await page.click('.choose >> nth=0')
  assert.deepEqual(await cycleTimes(page), before)
  await page.click('.remove >> nth=1')
  await page.fill('#tolerances form input', '35')
  await page.press('#tolerances form input', 'Enter')
  await page.waitForFunction(() => document.querySelectorAll('#tolerances data').length === 4)
  await computed(page)
  const times = await cycleTimes(page)
  assert.deepEqual([times[0], times[1], times[3]], before)
  assert.ok(before[2] < times[2] && times[2] < before[1])
})

longTest('results stay in sight, marked as out of date, while others are computed', async ({ page }) => {
  await page.setInputFiles('#files', longProgram(100_000))
  await computed(page)
  const before = await cycleTimes(page)
  await page.fill('#field-interpolator-time_constant_s', '0.04')
  await page.waitForSelector('#progress progress:visible')
  assert.ok(await page.isVisible('#results.stale'))
  assert.deepEqual(await cycleTimes(page), before)
  await page.click('#progress button')
  await page.waitForFunction(() => document.querySelector('#progress p').textContent.startsWith('Cancelled'))
  assert.ok(await page.isVisible('#results.stale'))
  assert.deepEqual(await cycleTimes(page), before)
  await page.click('#progress button')
  await computed(page)
  assert.ok((await cycleTimes(page)).every((time, index) => time > before[index]))
})

pageTest('tolerances are added, refused and removed as chips', async ({ page }) => {
  const labels = () => page.$$eval('.chip', (chips) => chips.map((chip) => chip.querySelector('.label').textContent))
  const add = async (text) => {
    await page.fill('#tolerances form input', text)
    await page.press('#tolerances form input', 'Enter')
    return page.textContent('#tolerances .fault')
  }
  await page.click('#welcome .sample')
  await computed(page)
  assert.equal(await add('15'), '')
  assert.deepEqual(await labels(), ['10 µm', '15 µm', '20 µm', '50 µm'])
  assert.match(await add('0.02 mm'), /there already/)
  assert.match(await add('ten'), /not a tolerance/)
  assert.match(await add('99999'), /out of range/)
  await page.focus('.chip:nth-child(2) button')
  await computed(page)
  assert.equal(await page.evaluate(() => document.activeElement?.closest('.chip')?.querySelector('.label')?.textContent), '15 µm', 'times that arrive take no focus away')
  await page.keyboard.press('Delete')
  await page.click('.chip:first-child button')
  assert.deepEqual(await labels(), ['20 µm', '50 µm'])
  await computed(page)
  assert.equal((await cycleTimes(page)).length, 2)
  await page.click('#tolerances .reset')
  assert.deepEqual(await labels(), ['10 µm', '20 µm', '50 µm'])
})

pageTest('the chart zooms, moves and reads by mouse and keys', async ({ page }) => {
  await page.click('#welcome .sample')
  await computed(page)
  const whole = await span(page)
  assert.equal(whole[0], 0)
  const box = await page.locator('#chart .plot').boundingBox()
  const at = (part) => [box.x + part * box.width, box.y + box.height / 2]
  const size = ([low, high]) => high - low

  await page.mouse.move(...at(0.6))
  assert.match(await page.textContent('#chart .reading'), /mm\/min.*line \d+ N\d+ /s)
  const picture = await page.$eval('.plot canvas', (canvas) => canvas.toDataURL())
  await page.keyboard.down('Control')
  for (let turn = 0; turn < 3; turn += 1) await page.mouse.wheel(0, -120)
  await page.keyboard.up('Control')
  const wheeled = await span(page)
  assert.ok(size(wheeled) < 0.6 * size(whole))
  assert.notEqual(await page.$eval('.plot canvas', (canvas) => canvas.toDataURL()), picture)

  await page.mouse.move(...at(0.4))
  await page.mouse.down()
  await page.mouse.move(at(0.7)[0], at(0.7)[1] + 80, { steps: 5 })
  await page.mouse.up()
  const boxed = await span(page)
  assert.ok(size(boxed) < 0.5 * size(wheeled))
  await shot(page, 'zoomed')

  await page.keyboard.down('Shift')
  await page.mouse.move(...at(0.4))
  await page.mouse.down()
  await page.mouse.move(...at(0.6), { steps: 5 })
  await page.mouse.up()
  await page.keyboard.up('Shift')
  const moved = await span(page)
  assert.ok(moved[0] < boxed[0])
  assert.ok(Math.abs(size(moved) - size(boxed)) < 1e-6 * size(whole))

  await page.focus('.plot')
  await page.keyboard.press('ArrowRight')
  assert.ok((await span(page))[0] > moved[0])
  await page.keyboard.press('-')
  assert.ok(size(await span(page)) > size(moved))
  await page.keyboard.press('Shift+ArrowRight')
  assert.ok(await page.isVisible('#chart .reading'))
  await page.keyboard.press('Home')
  assert.deepEqual(await span(page), whole)

  const below = box.y + 0.75 * box.height
  await page.mouse.move(at(0.3)[0], below)
  await page.mouse.down()
  await page.mouse.move(at(0.5)[0], below - 30, { steps: 5 })
  assert.ok((await page.locator('#chart .box').boundingBox()).height > 0.7 * box.height, 'the box spans both panels')
  await page.mouse.up()
  const among = await span(page)
  assert.ok(0 < among[0] && size(among) < 0.4 * size(whole))
  await page.mouse.dblclick(at(0.5)[0], below)
  assert.deepEqual(await span(page), whole)
})

longTest('the read-out tells the contour error that the table calls the largest', async ({ page }) => {
  // One corner of 90°, far from both ends: each curve takes its whole tolerance there.
  const program = Buffer.from('G21 G90\nG1 X100 F3000\nG1 Y100\n')
  await page.setInputFiles('#files', { name: 'corner.nc', mimeType: 'text/plain', buffer: program })
  await computed(page)
  // Reading by keys begins in the middle of the chart, where the corner is.
  await page.focus('.plot')
  await page.keyboard.press('Shift+ArrowRight')
  await page.keyboard.press('Shift+ArrowLeft')
  const errors = () => page.$$eval('.reading td:nth-child(3)', (cells) => cells.map(({ textContent }) => textContent))
  assert.deepEqual(await errors(), ['10.0 µm off', '20.0 µm off', '50.0 µm off'])
  const largest = await page.$$eval('#tolerances .deviation', (cells) => cells.map(({ textContent }) => textContent))
  assert.deepEqual(largest, ['10.0 µm', '20.0 µm', '50.0 µm'])
  assert.equal(await page.isVisible('.beyond'), false)
  for (let i = 0; i < 5; i += 1) await page.keyboard.press('Shift+ArrowRight')
  assert.deepEqual(await errors(), ['–', '–', '–'])
})

pageTest('places above the tolerance are named, shown in the chart and held by the guaranteed mode', async ({ page }) => {
  await page.click('#welcome .sample')
  await computed(page)
  const { runs } = await predicted(page, SAMPLE)
  const said = await page.$$eval('.beyond li', (items) => items.map(({ textContent }) => textContent))
  assert.equal(said.length, 3)
  runs.forEach(({ beyond_tolerance: places, max_contour_error_mm: largest }, index) => {
    assert.match(said[index], new RegExp(`in ${places.length} place`))
    assert.ok(said[index].includes(`worst ${(1000 * largest).toFixed(1)} µm, line`), said[index])
  })

  const whole = await span(page)
  const worst = runs[2].beyond_tolerance.reduce((a, b) => (b.max_contour_error_mm > a.max_contour_error_mm ? b : a))
  await page.focus('.beyond li:nth-child(3) button')
  await page.keyboard.press('Enter')
  const shown = await span(page)
  assert.ok(shown[0] <= worst.distance_mm[0] && worst.distance_mm[1] <= shown[1])
  assert.ok(shown[1] - shown[0] < 0.2 * (whole[1] - whole[0]))
  await shot(page, 'place')

  await page.click('#tolerances .cure')
  await page.waitForSelector('#results.stale')
  await computed(page)
  assert.equal(await page.inputValue('#field-interpolator-corner_mode'), 'guaranteed')
  assert.equal(await page.isVisible('.beyond'), false)
  const errors = await page.$$eval('#tolerances .deviation', (cells) => cells.map(({ textContent }) => textContent))
  errors.forEach((text, index) => assert.ok(parseFloat(text) <= 1000 * TOLERANCES_MM[index] + 0.05, text))
  await shot(page, 'guaranteed')
})

longTest('the bar moves within one tolerance in the guaranteed mode', async ({ page }) => {
  await page.selectOption('#field-interpolator-corner_mode', 'guaranteed')
  await page.evaluate(() => {
    const bar = document.querySelector('#progress progress')
    const values = new Set()
    new MutationObserver(() => values.add(bar.value)).observe(bar, { attributes: true })
    Object.assign(window, { barValues: values })
  })
  await page.click('#welcome .sample')
  await computed(page)
  const values = await page.evaluate(() => [...window.barValues])
  const steps = TOLERANCES_MM.length + 1
  const within = values.filter((value) => Math.abs(value * steps - Math.round(value * steps)) > 1e-6)
  assert.ok(within.length >= 3, `the bar stood at ${values}`)
  assert.deepEqual(
    values,
    [...values].sort((a, b) => a - b),
  )
})

pageTest(
  'a tap on the chart reads it on a phone, and the picture keeps its shape',
  async ({ page }) => {
    await page.click('#welcome .sample')
    await computed(page)
    await frame(page)
    const shape = () => page.$eval('.plot canvas', ({ width, height }) => [width, height])
    const before = await shape()
    // A phone has no mouse that rests where the chart will be.
    await page.mouse.move(0, 0)
    await page.locator('#chart .plot').scrollIntoViewIfNeeded()
    const touch = { pointerType: 'touch', pointerId: 1, button: 0, isPrimary: true, bubbles: true }
    await page.$eval(
      '.plot',
      (plot, options) => {
        const { left, top } = plot.getBoundingClientRect()
        plot.setPointerCapture = () => {}
        for (const type of ['pointerdown', 'pointerup']) {
          plot.dispatchEvent(new PointerEvent(type, { ...options, clientX: left + 150, clientY: top + 150 }))
        }
      },
      touch,
    )
    await frame(page)
    await frame(page)
    assert.match(await page.textContent('#chart .reading'), /mm\/min.*line \d+ N\d+ /s)
    assert.deepEqual(await shape(), before)
    await page.locator('#chart .reading').scrollIntoViewIfNeeded()
    await shot(page, 'reading-390')
  },
  { viewport: PHONE },
)

pageTest('several programs are computed one after another; a removal is undone', async ({ page }) => {
  const simple = (name, length) => ({
    name,
    mimeType: 'text/plain',
    buffer: Buffer.from(`G21 G90\nG1 X${length} F600\n`),
  })
  await page.setInputFiles('#files', [simple('a.nc', 10), simple('b.nc', 100), simple('c.nc', 1000)])
  await page.waitForFunction(() => {
    const about = [...document.querySelectorAll('.choose .about')]
    return about.length === 3 && about.every(({ textContent }) => /^\d+:\d\d:\d\d/.test(textContent))
  })
  const names = () => page.$$eval('.choose .file', (all) => all.map(({ textContent }) => textContent))
  const first = await cycleTimes(page)
  await page.click('.choose >> nth=2')
  const third = await cycleTimes(page)
  assert.ok(first[0] > 1 && first[0] < 2 && third[0] > 100)
  await page.click('.remove >> nth=2')
  assert.deepEqual(await names(), ['a.nc', 'b.nc'])
  await page.click('.undo button')
  assert.deepEqual(await names(), ['a.nc', 'b.nc', 'c.nc'])
  await computed(page)
  assert.deepEqual(await cycleTimes(page), third)
})

pageTest('the machine form refuses at the field, recomputes, prices, is kept and reset', async ({ page }) => {
  const field = (key) => `#field-${key.replaceAll('.', '-')}`
  await page.click('#welcome .sample')
  await computed(page)
  const before = await cycleTimes(page)
  const filters = field('interpolator.filters')
  await page.fill(filters, '9')
  assert.match(await page.textContent(`${filters}-fault`), /1 to 4/)
  await page.fill(filters, 'many')
  assert.notEqual(await page.textContent(`${filters}-fault`), '')
  assert.ok(await page.isVisible('#results.stale'))
  await page.fill(filters, '3')

  await page.fill(field('interpolator.time_constant_s'), '0.05')
  await computed(page)
  assert.ok((await cycleTimes(page))[0] > before[0])
  await page.fill(field('rates.hourly'), '72')
  const priceNow = async () => Number((await page.textContent('#quote .headline')).replace(/[^\d.]/g, ''))
  await page.waitForFunction(() => document.querySelector('#quote .headline').textContent.includes('€'))
  await computed(page)
  const price = await priceNow()
  assert.ok(Math.abs(price - ((await cycleTimes(page))[0] * 72) / 3600) <= 0.005)

  // A rate changes no motion: the price follows at once, and nothing is simulated again.
  await page.evaluate(() => {
    const busy = { stale: false }
    const watch = () => (busy.stale ||= Boolean(document.querySelector('.stale, #progress:not([hidden])')))
    new MutationObserver(watch).observe(document.body, { attributes: true, childList: true, subtree: true })
    Object.assign(window, { busy })
  })
  await page.fill(field('rates.hourly'), '144')
  assert.ok(Math.abs((await priceNow()) - 2 * price) <= 0.011)
  await page.fill(field('rates.hourly'), '')
  assert.equal(await page.textContent(`${field('rates.hourly')}-fault`), '')
  assert.match(await page.textContent('#quote .headline'), /No price yet/)
  await page.fill(field('rates.hourly'), '72')
  await page.waitForTimeout(600)
  assert.deepEqual(await page.evaluate(() => window.busy), { stale: false })

  await page.fill(field('times.tool_change_s'), '')
  assert.match(await page.textContent(`${field('times.tool_change_s')}-fault`), /expected a number from 0 to/)
  await page.fill(field('times.tool_change_s'), '4')
  // A rapid along the path may be missing where each axis has one of its own.
  await page.fill(field('rapid.feed_mm_min'), '')
  assert.match(await page.textContent(`${field('rapid.feed_mm_min')}-fault`), /give it, or axis\.x\.rapid_mm_min, axis\.y/)
  await page.fill(field('rapid.feed_mm_min'), '20000')
  await computed(page)

  await page.reload()
  await page.waitForSelector('html[data-ready]')
  assert.equal(await page.inputValue(field('rates.hourly')), '72')
  await page.click('#machine .reset')
  assert.equal(await page.inputValue(field('rates.hourly')), '0')
  assert.equal(await page.inputValue(field('interpolator.time_constant_s')), '0.0255')
})

longTest('what is no program is said to be none, and quotes nothing; files of one name are told apart', async ({ page }) => {
  const give = (name, bytes) => page.setInputFiles('#files', { name, mimeType: '', buffer: Buffer.from(bytes) })
  const says = (text) => page.waitForFunction((text) => document.querySelector('#results').textContent.includes(text), text)
  const standing = (index) => page.locator('.programs .about').nth(index).textContent()
  await give('empty.nc', [])
  await says('empty.nc is empty')
  for (const panel of ['#chart', '#compare', '#path', '#quote', '#breakdown']) assert.ok(await page.isHidden(panel), panel)
  assert.equal(await page.textContent('#results .time'), '–')
  assert.equal(await standing(0), 'nothing moves')

  await give(
    'photo.jpg',
    Array.from({ length: 50_000 }, (_, index) => ((index * index * 7919 + (index >> 3)) % 251) | 128),
  )
  await says('Nothing moves in photo.jpg')
  assert.ok(await page.isHidden('#quote'))

  for (const length of [10, 100]) await give('part.nc', `G21 G90\nG1 X${length} F1000\nM30`)
  await page.waitForFunction(() => document.querySelectorAll('.programs li').length === 4)
  await computed(page)
  assert.deepEqual((await page.locator('.programs .file').allTextContents()).slice(2), ['part.nc', 'part.nc (2)'])
  assert.ok(await page.isVisible('#quote'))

  // A table of which nothing can be read is a recording that says so.
  await give('log.csv', 't_s,x_mm\n')
  await page.waitForSelector('#recording .refused')
  assert.equal(await page.locator('.programs li').count(), 4)
})

pageTest('behind the chart is a table of what is in sight', async ({ page }) => {
  await page.click('#welcome .sample')
  await computed(page)
  const rows = () => page.$$eval('#chart .behind tbody tr', (all) => all.map(({ cells }) => [...cells].map((cell) => cell.textContent)))
  await page.click('#chart .behind summary')
  await page.waitForSelector('#chart .behind tbody tr')
  const whole = await rows()
  assert.equal(whole.length, 20)
  // The largest contour error of each tolerance is that of the table of cycle times.
  const largest = await page.$$eval('#tolerances .deviation', (all) => all.map(({ textContent }) => textContent))
  for (const [index, error] of largest.entries()) {
    const told = whole.map((row) => row[4 + 2 * index])
    assert.ok(told.includes(error), `${error} is among ${told}`)
  }
  const end = (all) => Number(all.at(-1)[0].split(' – ')[1].replaceAll(',', ''))
  const length = end(whole)
  assert.ok(length > 0 && whole[0][0].startsWith('0'), whole[0][0])

  // It follows the view and the axis.
  await page.focus('#chart .plot')
  await page.keyboard.press('+')
  await page.waitForFunction((first) => document.querySelector('#chart .behind tbody th').textContent !== first, whole[0][0])
  const zoomed = await rows()
  assert.equal(zoomed.length, 20)
  assert.ok(end(zoomed) < length)
  // However far it is zoomed, each row begins elsewhere.
  for (let times = 0; times < 12; times += 1) await page.keyboard.press('+')
  await page.waitForFunction((first) => document.querySelector('#chart .behind tbody th').textContent !== first, zoomed[0][0])
  await page.waitForTimeout(400)
  assert.equal(new Set((await rows()).map(([place]) => place)).size, 20, (await rows())[0][0])
  await page.selectOption('#chart .over', 'time')
  await page.waitForFunction(() => document.querySelector('#chart .behind thead th').textContent === 'Time')
  assert.match((await rows())[0][0], / s$/)
  await page.locator('#chart .behind').scrollIntoViewIfNeeded()
  await shot(page, 'behind')
})
