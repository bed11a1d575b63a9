// A recording dropped beside its program is compared with the simulation, and calibrates the machine. The recordings
// are made here, by simulating another machine and writing what a recorder would have seen of it.

import assert from 'node:assert/strict'
import { execFileSync } from 'node:child_process'
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after } from 'node:test'
import { atEverySize, binary, drop, frame, longTest, machineOf, pageTest, shot } from './steps.mjs'

const folder = mkdtempSync(join(tmpdir(), 'truefeed-recording-'))
after(() => rmSync(folder, { recursive: true }))
const file = (name, text) => {
  const path = join(folder, name)
  writeFileSync(path, text)
  return path
}

/** Zigzags with corners of all kinds, at two feeds. */
const PROGRAM = file(
  'bracket.nc',
  [
    'G21 G90 G94',
    'G0 X0 Y0 Z0',
    ...Array.from({ length: 24 }, (_, i) => `G1 X${(i % 2) * 30} Y${i * 2} F${i < 12 ? 2400 : 4200}`),
    ...Array.from({ length: 40 }, (_, i) => `G1 X${30 + i * 1.5} Y${46 + 3 * Math.sin(i)} F3600`),
    'G0 X0 Y0',
    'M30',
  ].join('\n'),
)
const OTHER = file('other.nc', ['G21 G90', 'G1 X200 F2000', 'G1 Y300', 'G1 X0', 'G1 Y0', 'M30'].join('\n'))
const THIRD = file('wheel.nc', ['G21 G90', 'G0 X0 Y0', 'G1 X80 F1500', ...Array.from({ length: 20 }, (_, i) => `G1 X${80 - 4 * i} Y${15 * (i % 3)}`), 'M30'].join('\n'))
const TIME_CONSTANT_S = 0.04

/** What a recorder at 250 Hz that was started half a second early sees of the machine in the form with another time constant. */
async function recorded(page, name, program = PROGRAM) {
  const machine = readFileSync(await machineOf(page), 'utf8')
  const changed = machine.replace(/time_constant_s = .*/, `time_constant_s = ${TIME_CONSTANT_S}`)
  assert.notEqual(changed, machine)
  const [machinePath, profilePath] = [file('changed.toml', changed), join(folder, 'profile.csv')]
  execFileSync(binary(), ['predict', program, '--machine', machinePath, '--profile', profilePath, '--json'])
  const [head, ...lines] = readFileSync(profilePath, 'utf8').trim().split('\n')
  const rows = lines.map((line) => line.split(',').map(Number))
  const columns = ['time_s', 'x_mm', 'y_mm', 'z_mm'].map((column) => head.split(',').indexOf(column))
  const out = ['t_s,x_mm,y_mm,z_mm']
  const end = rows.at(-1)[columns[0]]
  for (let t = -0.5, at = 0; t < end + 0.5; t += 0.004) {
    while (at + 2 < rows.length && rows[at + 1][columns[0]] <= t) at += 1
    const [a, b] = [rows[at], rows[at + 1]]
    const part = Math.min(Math.max((t - a[columns[0]]) / (b[columns[0]] - a[columns[0]] || 1), 0), 1)
    const position = columns.slice(1).map((column) => (a[column] + part * (b[column] - a[column])).toFixed(4))
    out.push([(t + 0.5).toFixed(4), ...position].join(','))
  }
  return { path: file(name, out.join('\n')), seconds: end }
}

/** Waits until the recording in sight is compared with the machine in the form. */
const compared = (page) =>
  page.waitForFunction(() => document.querySelector('#progress').hidden && !document.querySelector('.stale') && document.querySelector('#recording .sentence'), null, { timeout: 120_000 })

/** Pixels of the recording's canvas in the colours of both curves, in a part of its height. */
const pixels = (page, from, to) =>
  page.evaluate(
    ([low, high]) => {
      const canvas = document.querySelector('#recording canvas')
      const [top, height] = [Math.round(low * canvas.height), Math.round((high - low) * canvas.height)]
      const { data } = canvas.getContext('2d').getImageData(0, top, canvas.width, height)
      return [0, 1].map((index) => {
        const hex = getComputedStyle(document.documentElement).getPropertyValue(`--curve-${index}`)
        const wanted = hex.match(/\d+/g).map(Number)
        let count = 0
        for (let i = 0; i < data.length; i += 4) if (wanted.every((value, channel) => Math.abs(data[i + channel] - value) <= 2)) count += 1
        return count
      })
    },
    [from, to],
  )

/** The stretch that a chart shows; only what is in sight is drawn. */
async function spanOf(page, root) {
  await page.locator(`${root} .plot canvas`).scrollIntoViewIfNeeded()
  await frame(page)
  return (await page.getAttribute(`${root} .plot`, 'data-span')).split(' ').map(Number)
}
const cell = (page, row, column) => page.textContent(`#calibration tbody tr:has(th:text-is("${row}")) >> td >> nth=${column}`)

pageTest('program and recording dropped together are compared', async ({ page }) => {
  const { path, seconds } = await recorded(page, 'bracket-07.csv')
  await drop(page, 'body', [path, PROGRAM])
  await compared(page)
  assert.equal(await page.locator('.programs li').count(), 1, 'the recording is no program')
  const sentence = await page.textContent('#recording .sentence')
  const [, took, simulated] = sentence.match(/^The machine took ([\d.]+) s, the simulation ([\d.]+) s \(−\d/)
  // Where the tool starts and ends a recorder of positions sees only to its resolution.
  assert.ok(Math.abs(Number(took) - seconds) < 0.25, `${took} s of ${seconds} s`)
  assert.ok(Number(simulated) < Number(took) - 0.5, sentence)
  assert.match(await page.textContent('#recording .facts'), /aligned by axis positions: (99|100) %/)
  assert.equal(await page.locator('#recording [role=toolbar] .picture').count(), 2, 'the chart leaves as SVG and PNG')
  // The tables come a moment later, and move what is in sight.
  await page.waitForSelector('#recording .tables > :last-child tbody tr')
  await page.locator('#recording .plot canvas').scrollIntoViewIfNeeded()
  await frame(page)
  const [feeds, lost] = [await pixels(page, 0.1, 0.55), await pixels(page, 0.62, 1)]
  assert.ok(
    feeds.every((count) => 300 < count),
    `curves: ${feeds}`,
  )
  assert.ok(300 < lost[0], `time lost: ${lost}`)

  const rows = await page.$$eval('#recording .tables > :last-child tbody tr', (all) => all.map((row) => row.cells.length))
  assert.ok(5 < rows.length && rows.every((count) => count === 5))
  await page.locator('#recording').scrollIntoViewIfNeeded()
  await atEverySize(page, 'recording')
})

pageTest('a recording without times is read at the interval that is stated, and the statement can be taken back', async ({ page }) => {
  const { path, seconds } = await recorded(page, 'timed.csv')
  const rows = readFileSync(path, 'utf8').trim().split('\n')
  const bare = file('bare.csv', rows.map((row) => row.split(',').slice(1).join(',')).join('\n'))
  await drop(page, 'body', [bare, PROGRAM])
  await compared(page)
  assert.match(await page.textContent('#recording .refused'), /No time column/)
  await page.fill('#interval', '0.004')
  await page.press('#interval', 'Enter')
  await page.waitForFunction(() => /^The machine took/.test(document.querySelector('#recording .sentence')?.textContent), null, { timeout: 120_000 })
  const [, took] = (await page.textContent('#recording .sentence')).match(/^The machine took ([\d.]+) s/)
  assert.ok(Math.abs(Number(took) - seconds) < 0.25, `${took} s of ${seconds} s`)
  assert.equal(await page.inputValue('#interval'), '0.004')
  await page.evaluate(() => document.activeElement?.blur())
  await page.keyboard.press('Control+z')
  await page.waitForSelector('#recording .refused', { timeout: 120_000 })
})

longTest('all charts have one cursor and one stretch in sight', async ({ page }) => {
  const { path } = await recorded(page, 'run.csv')
  await drop(page, 'body', [PROGRAM, path])
  await compared(page)
  const plot = page.locator('#recording .plot')
  // A chart is drawn when it comes in sight, and read from then on.
  for (const chart of ['#chart', '#recording']) {
    await page.locator(`${chart} .plot`).scrollIntoViewIfNeeded()
    await page.waitForFunction((chart) => document.querySelector(`${chart} .plot`).dataset.span, chart)
  }
  const { x, y, width, height } = await plot.boundingBox()
  await page.mouse.move(x + 0.6 * width, y + 0.3 * height)
  await page.waitForFunction(() => document.querySelector('#recording .reading').textContent)
  const words = await page.textContent('#recording .reading')
  assert.match(words, /mm · programmed [\d,]+ mm\/min.*recorded.*simulated.*time lost so far \+[\d.]+ s.*line \d+ G1 X/)
  assert.ok(await page.isVisible('#chart .cross'), 'the cursor is in the chart above as well')
  assert.ok(await page.isHidden('#chart .reading'))
  const crossings = await page.$$eval('#chart .cross, #recording .cross', (all) => all.map((cross) => Number.parseFloat(cross.style.left)))
  assert.ok(Math.abs(crossings[0] - crossings[1]) < 30, `${crossings}`)

  await page.mouse.click(x + 0.6 * width, y + 0.3 * height)
  assert.match(await page.textContent('#recording .chosen'), /line \d+ G1 X/)
  await page.mouse.move(5, 5)
  assert.ok(await page.isHidden('#chart .cross'))

  await plot.focus()
  await page.keyboard.press('+')
  const near = ([a, b], [c, d]) => Math.abs(a - c) < 1e-6 && Math.abs(b - d) < 1e-6
  // A chart that was out of sight is drawn some frames later where the machine has other work.
  const areTogether = async () => {
    for (let tries = 0; tries < 20; tries += 1) if (near(await spanOf(page, '#recording'), await spanOf(page, '#chart'))) return true
    return false
  }
  assert.ok(await areTogether())
  const whole = await spanOf(page, '#chart')
  await page.focus('#chart .plot')
  await page.keyboard.press('ArrowRight')
  assert.ok(!near(whole, await spanOf(page, '#chart')))
  assert.ok(await areTogether())
  await page.focus('#recording .tables > :last-child button')
  await page.keyboard.press('Enter')
  assert.ok(await areTogether())
  assert.ok(!near(whole, await spanOf(page, '#chart')))
})

longTest('what is no recording of the program is refused with what to do, and nothing else is lost', async ({ page }) => {
  const { path } = await recorded(page, 'of-other.csv', OTHER)
  await drop(page, 'body', [PROGRAM, path])
  await compared(page)
  assert.ok(await page.isVisible('#recording .refused'))
  assert.match(await page.textContent('#recording .answer'), /program.*[Cc]hoose the program that ran.*do not change/s)
  assert.ok(await page.isHidden('#recording .plot'))
  await page.waitForSelector('#calibration:not([hidden])')
  assert.ok(await page.isDisabled('#calibration .start'))
  assert.ok((await page.$$('#tolerances data')).length > 0, 'the simulation is still there')

  const still = file('still.csv', ['t_s,x_mm,y_mm', ...Array.from({ length: 50 }, (_, i) => `${i * 0.01},1,2`)].join('\n'))
  await page.setInputFiles('#recordings', still)
  await compared(page)
  assert.match(await page.textContent('#recording .refused'), /nothing moves|does not move/i)

  // The program that was run: by hand.
  await page.setInputFiles('#files', OTHER)
  await page.selectOption('.pairs li:first-child select', { label: 'other.nc' })
  await compared(page)
  assert.match(await page.textContent('#recording .sentence'), /^The machine took/)

  await page.click('.pairs li:first-child .remove')
  assert.equal(await page.locator('.pairs li').count(), 1)
  await page.click('#recording .undo button')
  assert.equal(await page.locator('.pairs li').count(), 2)
})

longTest('a recording before its program waits for it', async ({ page }) => {
  const { path } = await recorded(page, 'early.csv')
  await drop(page, 'body', [path])
  await page.waitForFunction(() => document.querySelector('#welcome .orphans').textContent !== '')
  assert.match(await page.textContent('#welcome .orphans'), /early\.csv.*drop the program/)
  await drop(page, 'body', [PROGRAM])
  await compared(page)
  assert.match(await page.textContent('#recording .sentence'), /^The machine took/)
})

pageTest('the calibration brings the time constant back, by keyboard alone, and can be undone', async ({ page }) => {
  const field = '#field-interpolator-time_constant_s'
  const before = await page.inputValue(field)
  const { path } = await recorded(page, 'bracket-08.csv')
  await page.setInputFiles('#files', PROGRAM)
  await page.setInputFiles('#recordings', path)
  await compared(page)
  await page.focus('#recordings')
  for (let steps = 0; steps < 80; steps += 1) {
    if (await page.evaluate(() => document.activeElement?.matches('#calibration .start'))) break
    await page.keyboard.press('Tab')
  }
  await page.keyboard.press('Enter')
  await page.waitForSelector('#calibration .sentence', { timeout: 120_000 })
  await compared(page)
  const found = Number(await page.inputValue(field))
  assert.ok(Math.abs(found / TIME_CONSTANT_S - 1) < 0.01, `${found} s`)
  assert.match(await cell(page, 'Time constant T1 (s)', 1), /^0\.04\d* ± 0\.\d+$/)
  assert.equal(await cell(page, 'Time constant T1 (s)', 2), 'fitted')
  assert.match(await page.textContent('#calibration'), /bracket-08\.csv.*−\d+\.\d %.*→/s)
  const [, error] = (await page.textContent('#recording .sentence')).match(/\(([+−]?[\d.]+) %\)/)
  assert.ok(Math.abs(Number(error.replace('−', '-'))) <= 0.2, `${error} %`)
  // What was fitted is quoted, with as many figures as are known, and its range stays.
  const fitted = Number(await page.inputValue('#field-interpolator-contour_tolerance_mm'))
  const quoted = await page.textContent('#bar .tolerance .name')
  assert.match(quoted, /^\d{1,3}(?:\.\d{1,2})? µm$/)
  assert.ok(Math.abs(Number.parseFloat(quoted) / (1000 * fitted) - 1) < 0.006, `${quoted} for ${fitted} mm`)
  assert.ok(await page.isVisible('#results .range'))
  assert.match(await page.textContent('#bar .machine .small'), /^±\d{1,2}(?:\.\d)? %$/)
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#calibration .save')])
  await download.saveAs(join(folder, 'calibrated.toml'))
  const saved = readFileSync(join(folder, 'calibrated.toml'), 'utf8')
  assert.match(saved, /name = ".*, calibrated"/)
  assert.ok(saved.includes(`time_constant_s = ${found}`), saved)
  await page.locator('#calibration').scrollIntoViewIfNeeded()
  await shot(page, 'calibrated')

  await page.click('.undo-calibration')
  assert.equal(await page.inputValue(field), before)
  assert.equal(await page.textContent('#bar .tolerance .name'), '10 µm', 'what was quoted before is quoted again')
  await compared(page)
  assert.equal(await page.locator('#calibration .sentence').count(), 0)
})

longTest('several recordings of two programs dropped at once are told apart, compared one by one and calibrate together', async ({ page }) => {
  const all = [await recorded(page, 'bracket-11.csv'), await recorded(page, 'bracket-12.csv'), await recorded(page, 'other-3.csv', OTHER)]
  const [first, , third] = all.map(({ seconds }) => seconds)
  await drop(page, 'body', [all[2].path, PROGRAM, all[0].path, OTHER, all[1].path])
  await compared(page)
  const entry = (name) => page.locator('#recording .pairs li', { hasText: name })
  const standing = (name) => entry(name).locator('.about').textContent()
  const isCurrent = async (name) => (await entry(name).locator('.choose').getAttribute('aria-current')) === 'true'
  await page.waitForFunction(() => [...document.querySelectorAll('#recording .pairs .about')].every(({ textContent }) => /recorded/.test(textContent)), null, { timeout: 120_000 })
  assert.equal(await page.locator('.programs li').count(), 2)
  assert.equal(await page.locator('#recording .pairs li').count(), 3)
  for (const [name, program] of [
    ['bracket-11.csv', 'bracket.nc'],
    ['bracket-12.csv', 'bracket.nc'],
    ['other-3.csv', 'other.nc'],
  ]) {
    const of = entry(name).locator('select')
    assert.equal(await of.evaluate((select) => select.selectedOptions[0].textContent), program, name)
  }

  // Choosing a recording shows it, and its program, in list, sentence and chart.
  const took = async () => Number((await page.textContent('#recording .sentence')).match(/took ([\d.]+) s/)[1])
  for (const [name, program, seconds] of [
    ['other-3.csv', 'other.nc', third],
    ['bracket-11.csv', 'bracket.nc', first],
  ]) {
    await entry(name).locator('.choose').click()
    await compared(page)
    assert.ok(await isCurrent(name))
    assert.match(await page.textContent('.programs [aria-selected=true]'), new RegExp(`^${program}`))
    assert.ok(Math.abs((await took()) - seconds) < 0.3, `${name}: ${await took()} s of ${seconds} s`)
    assert.match(await standing(name), /simulation off by −/)
  }

  await page.locator('#recording').scrollIntoViewIfNeeded()
  await shot(page, 'recordings')
  await entry('bracket-12.csv').locator('input').uncheck()
  assert.match(await page.textContent('#calibration .start'), /from 2 recordings/)
  assert.match(await page.textContent('#diagnosis .start'), /2 recordings together/)
  await entry('bracket-12.csv').locator('input').check()
  assert.match(await page.textContent('#calibration .start'), /from 3 recordings/)
  await page.click('#calibration .start')
  await page.waitForSelector('#calibration .sentence', { timeout: 120_000 })
  await compared(page)
  const found = Number(await page.inputValue('#field-interpolator-time_constant_s'))
  assert.ok(Math.abs(found / TIME_CONSTANT_S - 1) < 0.01, `${found} s`)
  const runs = await page.$$eval('#calibration .result table:last-of-type tbody th', (all) => all.map(({ textContent }) => textContent))
  assert.deepEqual(runs.filter((name) => name.endsWith('.csv')).sort(), ['bracket-11.csv', 'bracket-12.csv', 'other-3.csv'])
  assert.ok(await isCurrent('bracket-11.csv'), 'what was chosen stays chosen')
})

longTest('a recording finds its program by what it holds, whatever its name says, and one of none says so', async ({ page }) => {
  const [ofBracket, ofOther, ofNone] = [await recorded(page, 'other-5.csv'), await recorded(page, 'bracket-5.csv', OTHER), await recorded(page, 'bracket-6.csv', THIRD)]
  const standing = (name) => page.textContent(`#recording .pairs li:has-text("${name}") .about`)
  const of = (name) => page.$eval(`#recording .pairs li:has-text("${name}") select`, (select) => select.selectedOptions[0].textContent)
  await drop(page, 'body', [ofBracket.path, ofOther.path, ofNone.path, PROGRAM, OTHER])
  const settled = () =>
    page.waitForFunction(
      () =>
        document.querySelector('#progress').hidden &&
        document.querySelectorAll('#recording .pairs li').length === 3 &&
        ![...document.querySelectorAll('#recording .pairs .about')].some(({ textContent }) => /waiting|finding/.test(textContent)),
      null,
      { timeout: 120_000 },
    )
  await settled()
  assert.deepEqual([await of('other-5.csv'), await of('bracket-5.csv'), await of('bracket-6.csv')], ['bracket.nc', 'other.nc', 'choose'])
  assert.match(await standing('bracket-6.csv'), /fits none of the open programs/)
  assert.match(await standing('other-5.csv'), /recorded/)
  await shot(page, 'recordings-paired')
  // Its own program comes later, and is found then; what was found before stays.
  await drop(page, 'body', [file('third.nc', readFileSync(THIRD, 'utf8'))])
  await page.waitForFunction(
    () => /recorded/.test([...document.querySelectorAll('#recording .pairs li')].find((row) => row.textContent.includes('bracket-6.csv')).querySelector('.about').textContent),
    null,
    { timeout: 120_000 },
  )
  assert.deepEqual([await of('other-5.csv'), await of('bracket-5.csv'), await of('bracket-6.csv')], ['bracket.nc', 'other.nc', 'third.nc'])
  // What a user says takes the place of it, and is taken back.
  await page.selectOption('#recording .pairs li:has-text("other-5.csv") select', { label: 'other.nc' })
  await page.waitForFunction(() => document.querySelector('#recording .refused'), null, { timeout: 120_000 })
  await page.click('#history .undo-change')
  await settled()
  assert.equal(await of('other-5.csv'), 'bracket.nc')
})

longTest('between programs that a recording cannot tell apart its name decides, or the user', async ({ page }) => {
  const { path } = await recorded(page, 'twin-b-1.csv')
  const [first, second] = ['twin-a.nc', 'twin-b.nc'].map((name) => file(name, readFileSync(PROGRAM, 'utf8')))
  const unnamed = file('log.csv', readFileSync(path, 'utf8'))
  await drop(page, 'body', [first, second, path, unnamed])
  await page.waitForFunction(() => document.querySelector('#progress').hidden && /could be any/.test(document.querySelector('#recording .pairs')?.textContent), null, { timeout: 120_000 })
  const of = (name) => page.$eval(`#recording .pairs li:has-text("${name}") select`, (select) => select.selectedOptions[0].textContent)
  assert.deepEqual([await of('twin-b-1.csv'), await of('log.csv')], ['twin-b.nc', 'choose'])
  assert.match(await page.textContent('#recording .pairs li:has-text("log.csv") .about'), /any of these: twin-a\.nc, twin-b\.nc\. Choose one/)
})

longTest('a calibration can be cancelled, and leaves the machine as it was', async ({ page }) => {
  const field = '#field-interpolator-time_constant_s'
  const before = await page.inputValue(field)
  const { path } = await recorded(page, 'bracket-09.csv')
  // The same run many times over takes long enough to be cancelled.
  const copies = Array.from({ length: 12 }, (_, i) => file(`copy-${i}.csv`, readFileSync(path, 'utf8')))
  await page.setInputFiles('#files', PROGRAM)
  await page.setInputFiles('#recordings', copies)
  await compared(page)
  await page.waitForFunction(() => /12 recordings/.test(document.querySelector('#calibration .start').textContent))
  await page.click('#calibration .start')
  await page.waitForFunction(() => /Calibrating/.test(document.querySelector('#progress p').textContent))
  await page.click('#progress button')
  await page.waitForSelector('#progress', { state: 'hidden' })
  assert.equal(await page.inputValue(field), before)
  assert.equal(await page.locator('#calibration .sentence').count(), 0)
  assert.ok(await page.isEnabled('#calibration .start'))
  assert.match(await page.textContent('#recording .sentence'), /^The machine took/)
})
