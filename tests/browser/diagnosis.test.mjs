// The diagnosis on the page: of the sample, in which a feed override of 78 % from line 31 on is concealed, and of what
// cannot be diagnosed.

import assert from 'node:assert/strict'
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after } from 'node:test'
import { ROOT, atEverySize, drop, frame, kept, longTest, pageTest } from './steps.mjs'

const folder = mkdtempSync(join(tmpdir(), 'truefeed-diagnosis-'))
after(() => rmSync(folder, { recursive: true }))
const sample = (name) => join(ROOT, 'www/samples', name)
const FEED = '#field-override-feed'
const TIMEOUT = { timeout: 120_000 }

/** Waits until the recording in sight is compared and nothing runs. */
const compared = (page) =>
  page.waitForFunction(() => document.querySelector('#progress').hidden && !document.querySelector('.stale') && document.querySelector('#recording .answer .sentence'), null, TIMEOUT)
const diagnosed = (page) => page.waitForFunction(() => document.querySelector('#diagnosis .sentence').textContent, null, TIMEOUT)

/** Loads the sample from the first page, which diagnoses itself. */
async function diagnoseSample(page) {
  await page.click('#welcome .concealed')
  await diagnosed(page)
  await compared(page)
}

/** The text of a file that a button saves. */
async function saved(page, button, name) {
  const [download] = await Promise.all([page.waitForEvent('download'), page.click(button)])
  const path = join(folder, name)
  await download.saveAs(path)
  return { text: readFileSync(path, 'utf8'), suggested: download.suggestedFilename() }
}

/** The values of the machine form. */
const formOf = (page) => page.$$eval('#machine [id^="field-"]', (all) => all.map((field) => field.value ?? field.checked))

/** Cells of a row of a table of the diagnosis. */
const cells = (page, name) =>
  page.evaluate((wanted) => {
    const rows = [...document.querySelectorAll('#diagnosis tbody tr')]
    const found = rows.find((own) => own.cells[0].textContent.startsWith(wanted))
    return [...(found?.cells ?? [])].map((own) => own.textContent)
  }, name)

/** The account's rows add up to the hundredth, and its bars join each other. */
async function addsUp(page) {
  const rows = await page.$$eval('#diagnosis .account tr', (all) =>
    all.map((row) => {
      const bar = row.querySelector('.bar i').getBoundingClientRect()
      return { name: row.cells[0].textContent, hundredths: Math.round(100 * Number.parseFloat(row.cells[1].textContent.replace('−', '-'))), left: bar.left, right: bar.right }
    }),
  )
  const [simulated, ...steps] = rows
  const recorded = steps.pop()
  assert.deepEqual([simulated.name, steps[0].name, steps.at(-1).name, recorded.name], ['simulated', 'feed override (on some lines)', 'unexplained', 'recorded'])
  assert.equal(
    steps.reduce((sum, { hundredths }) => sum + hundredths, simulated.hundredths),
    recorded.hundredths,
  )
  assert.ok(Math.abs(steps[0].left - simulated.right) < 1, 'the first cause begins where the simulated time ends')
  assert.ok(100 < steps[0].right - steps[0].left, 'its bar can be seen')
}

/** Pixels of the diagnosis' chart in each curve's colour in the lower panel. */
const lostPixels = (page) =>
  page.evaluate(() => {
    const canvas = document.querySelector('#diagnosis canvas')
    const top = Math.round(0.62 * canvas.height)
    const { data } = canvas.getContext('2d').getImageData(0, top, canvas.width, canvas.height - top)
    return [1, 2].map((index) => {
      const wanted = getComputedStyle(document.documentElement).getPropertyValue(`--curve-${index}`).match(/\d+/g).map(Number)
      let count = 0
      for (let i = 0; i < data.length; i += 4) if (wanted.every((value, channel) => Math.abs(data[i + channel] - value) <= 2)) count += 1
      return count
    })
  })

pageTest('what is concealed in the sample is found', async ({ page }) => {
  await page.click('#welcome .concealed')
  await page.waitForFunction(() => /Diagnosing/.test(document.querySelector('#progress p').textContent))
  await diagnosed(page)
  const sentence = await page.textContent('#diagnosis .sentence')
  assert.match(sentence, /^The run took [\d.]+ s, [\d.]+ s longer than simulated: from line 31 on the machine ran at 78 % of the programmed feed: feed override \([\d.]+ s\); /)
  await addsUp(page)
  assert.equal(await page.getAttribute('#diagnosis .sentence', 'aria-live'), 'polite')
  const cause = await page.textContent('#diagnosis .cause')
  assert.match(cause, /ratio.*7[78]\.\d %/s)
  assert.match(cause, /Confidence.*\d+ %; better in \d+ of \d+ validation sections/s)
  const [, before, found] = await cells(page, 'Feedrate error (RMS), validation')
  assert.ok(Number.parseFloat(found) < 0.5 * Number.parseFloat(before), `${before} → ${found}`)
  await page.locator('#diagnosis .plot canvas').scrollIntoViewIfNeeded()
  await frame(page)
  const pixels = await lostPixels(page)
  assert.ok(
    pixels.every((count) => 200 < count),
    `time lost before and after: ${pixels}`,
  )
  await atEverySize(page, 'diagnosis', async (name) => {
    await page.locator('#diagnosis').screenshot({ path: join(ROOT, `tests/browser/output/${name}.png`) })
  })

  // A region is shown in the charts, each of which is drawn when it comes in sight.
  const whole = await page.getAttribute('#diagnosis .plot', 'data-span')
  await page.click('#diagnosis .scroll button')
  await page.locator('#diagnosis .plot canvas').scrollIntoViewIfNeeded()
  await page.waitForFunction((whole) => document.querySelector('#diagnosis .plot').dataset.span !== whole, whole)
})

longTest('the extended machine is used, undone, saved and varied; the report is exported', async ({ page }) => {
  const own = await formOf(page)
  await diagnoseSample(page)
  const stock = await formOf(page)
  assert.notDeepEqual(stock, own)

  await page.waitForFunction(() => /with the diagnosed machine/.test(document.querySelector('#diagnosis .what-if')?.textContent ?? ''), null, TIMEOUT)
  const box = page.locator('#try-override-feed')
  await box.fill('1')
  await box.press('Enter')
  await page.waitForFunction(() => /saves 8\.\d s/.test(document.querySelector('#diagnosis .what-if').textContent), null, TIMEOUT)
  await box.fill('fast')
  await box.press('Enter')
  assert.match(await page.textContent('#diagnosis .trial .fault'), /fast is not a number/)

  await page.click('.use-diagnosis')
  assert.ok(Math.abs(Number(await page.inputValue(FEED)) - 0.78) < 0.001)
  await compared(page)
  const [, error] = (await page.textContent('#recording .sentence')).match(/\(([+−]?[\d.]+) %\)/)
  assert.ok(Math.abs(Number(error.replace('−', '-'))) <= 0.2, `${error} %`)
  await page.click('.use-diagnosis')
  assert.deepEqual(await formOf(page), stock)
  await page.click('#diagnosis .restore button')
  assert.deepEqual(await formOf(page), own)

  const machine = await saved(page, '#diagnosis .save', 'machine.toml')
  assert.match(machine.text, /from_mm = \d/)
  const json = await saved(page, '#diagnosis .json', 'diagnosis.json')
  assert.equal(json.suggested, 'diagnosis.json')
  const report = JSON.parse(json.text)
  assert.equal(report.verdict, 'explained')
  assert.equal(report.causes[0].id, 'feed_override')
  assert.equal(report.causes[0].parameters.from_line, 31)
  const html = await saved(page, '#diagnosis .html', 'diagnosis.html')
  assert.equal(html.suggested, 'diagnosis.html')
  const parsed = await page.evaluate((text) => {
    const document = new DOMParser().parseFromString(text.replace(/^.*\n/, ''), 'application/xml')
    const count = (name) => document.getElementsByTagName(name).length
    return { faults: count('parsererror'), charts: count('svg'), scripts: count('script'), says: document.getElementsByTagName('h1')[0]?.textContent }
  }, html.text)
  assert.ok(0 < report.measured.laws.length, 'laws are measured, each with a chart')
  assert.deepEqual([parsed.faults, parsed.charts, parsed.scripts], [0, 1 + report.measured.laws.length, 0])
  assert.match(parsed.says, /78 % of the programmed feed/)
  assert.ok(!/(src|href)=/.test(html.text), 'the report needs no other file')
})

pageTest('names of files and machines, comments and columns carry no script, into the page or into the report', async ({ page }) => {
  const carrier = '<img src=x onerror=alert(1)><script>alert(2)</script>'
  // A file's name has no slash.
  const name = `part"'&<img src=x onerror=alert(1)><svg onload=alert(3)>`
  const file = (name, text) => ({ name, mimeType: '', buffer: Buffer.from(text) })
  const read = (name) => readFileSync(sample(name), 'utf8')
  const program = `(${carrier})\n${read('standin.nc')}`.replace('G21 G90 G17', `G21 G90 G17 (MSG,${carrier}) &?${carrier}`)
  const [head, ...rows] = read('standin.csv').trim().split('\n')
  const recording = [`${head},${carrier},"<b>""`, ...rows.map((row) => `${row},${carrier},0`)].join('\n')
  const machine = read('standin.toml')
    .replace(/^name = .*$/m, '')
    .replace(/^/, `name = ${JSON.stringify(carrier + name)}\n`)
  let dialogs = 0
  page.context().on('dialog', (dialog) => ((dialogs += 1), dialog.dismiss()))
  await page.setInputFiles('#files', [file('standin.toml', machine)])
  await page.waitForFunction((name) => document.querySelector('#field-name').value === name, carrier + name)
  await page.setInputFiles('#files', [file(`${name}.nc`, program), file(`${name}.csv`, recording)])
  await compared(page)
  assert.equal(await page.textContent('.programs .file'), `${name}.nc`)
  await page.click('#diagnosis .start')
  await diagnosed(page)

  /** What a file could have brought in: elements that load or run something, and handlers. */
  const brought = () =>
    [...document.querySelectorAll('*')]
      .filter(
        (element) => element.matches('img:not(#welcome img, #letter img), iframe, object, embed, b[onclick], script:not([src])') || [...element.attributes].some(({ name }) => name.startsWith('on')),
      )
      .map((element) => element.outerHTML.slice(0, 200))
  assert.deepEqual(await page.evaluate(brought), [])
  const html = await saved(page, '#diagnosis .html', 'carrier.html')
  const json = await saved(page, '#diagnosis .json', 'carrier.json')
  assert.ok(JSON.parse(json.text))
  assert.ok(html.text.includes('&lt;img'), 'the report names the file')
  const report = await page.context().newPage()
  await report.setContent(html.text)
  assert.match(await report.textContent('h1'), /programmed feed/)
  assert.deepEqual(await report.evaluate(brought), [])
  assert.equal(dialogs, 0)
})

longTest('a diagnosis of what was before is marked, until that is back or it is made again', async ({ page }) => {
  const note = () => page.textContent('#diagnosis .outdated')
  const holds = () => page.isHidden('#diagnosis .outdated')
  await diagnoseSample(page)
  assert.ok(await holds())
  await page.click('.use-diagnosis')
  assert.ok(await holds(), 'the machine it found is its own')
  await page.click('.use-diagnosis')
  assert.ok(await holds())

  const box = page.locator(FEED)
  await page.click('#machine summary')
  await box.fill('0.5')
  await box.press('Tab')
  assert.match(await note(), /for earlier machine settings/)
  await page.waitForFunction(() => getComputedStyle(document.querySelector('#diagnosis .plot canvas')).opacity === '0.4')
  await page.locator('#diagnosis').screenshot({ path: join(ROOT, 'tests/browser/output/diagnosis-outdated.png') })
  await page.click('.undo-change')
  assert.ok(await holds(), 'the machine it is of is back')

  await compared(page)
  await page.click('#recording .use input')
  assert.match(await note(), /for earlier recordings or another program/)
  assert.ok(await page.isDisabled('#diagnosis .outdated button'), 'nothing is left to diagnose')
  await page.click('#recording .use input')
  assert.ok(await holds())
  await page.selectOption('#dialect', 'linuxcnc')
  assert.match(await note(), /for earlier recordings or another program/)
  await compared(page)
  await page.click('#diagnosis .outdated button')
  await page.waitForFunction(() => /Diagnosing/.test(document.querySelector('#progress p').textContent))
  await page.waitForSelector('#progress', { state: 'hidden', ...TIMEOUT })
  assert.ok(await holds(), 'it is made again')
})

pageTest('a diagnosis can be cancelled, and leaves everything as it was', async ({ page }) => {
  await page.setInputFiles('#files', sample('standin.toml'))
  await page.waitForFunction(() => /stand-in/i.test(document.querySelector('#field-name').value))
  await page.setInputFiles('#files', [sample('standin.nc'), sample('standin.csv')])
  await compared(page)
  const before = await formOf(page)
  const sentence = await page.textContent('#recording .sentence')
  await page.click('#diagnosis .start')
  await page.waitForFunction(() => /Diagnosing/.test(document.querySelector('#progress p').textContent))
  await page.click('#progress button')
  await page.waitForSelector('#progress', { state: 'hidden' })
  assert.deepEqual(await formOf(page), before)
  assert.equal(await page.textContent('#recording .sentence'), sentence)
  assert.equal(await page.textContent('#diagnosis .sentence'), '')
  assert.ok(await page.isHidden('#diagnosis .view'))
  assert.ok(await page.isEnabled('#diagnosis .start'))
})

longTest('a reload keeps what was found', async ({ page }) => {
  await diagnoseSample(page)
  const [sentence, numbers] = await page.$$eval('#diagnosis .sentence, #diagnosis .result', (all) => all.map(({ textContent }) => textContent))
  await kept(page, ({ isDiagnosed }) => isDiagnosed)
  await page.reload()
  await compared(page)
  await diagnosed(page)
  assert.equal(await page.textContent('#diagnosis .sentence'), sentence)
  await page.waitForFunction(() => document.querySelector('#diagnosis .what-if')?.textContent)
  assert.equal((await page.textContent('#diagnosis .result')).slice(0, 200), numbers.slice(0, 200))
  assert.ok(await page.isHidden('#diagnosis .outdated'), await page.textContent('#diagnosis .outdated'))
  await page.click('#diagnosis .restore button')
  assert.ok(await page.isVisible('#diagnosis .outdated'))
})

pageTest('a recording that is refused says why, and is not diagnosed', async ({ page }) => {
  const other = join(folder, 'other.nc')
  writeFileSync(other, ['G21 G90', 'G1 X200 F2000', 'G1 Y300', 'G1 X0', 'G1 Y0', 'M30'].join('\n'))
  await drop(page, 'body', [other, sample('standin.csv')])
  await page.waitForSelector('#recording .refused', TIMEOUT)
  await page.waitForSelector('#progress', { state: 'hidden' })
  assert.ok(await page.isDisabled('#diagnosis .start'))
  assert.equal(await page.textContent('#diagnosis .why'), 'standin.csv cannot be diagnosed, as it cannot be compared with its program.')
})

pageTest('the keyboard alone finds what is concealed', async ({ page }) => {
  const press = async (selector) => {
    for (let steps = 0; steps < 150; steps += 1) {
      if (await page.evaluate((wanted) => document.activeElement?.matches(wanted), selector)) break
      await page.keyboard.press('Tab')
    }
    assert.ok(await page.evaluate((wanted) => document.activeElement?.matches(wanted), selector), `${selector} cannot be reached`)
    await page.keyboard.press('Enter')
  }
  await press('#welcome .concealed')
  await diagnosed(page)
  await compared(page)
  await press('#diagnosis .use-diagnosis')
  assert.ok(Math.abs(Number(await page.inputValue(FEED)) - 0.78) < 0.001)
  assert.match(await page.textContent('#diagnosis .use-diagnosis'), /Undo/)
  assert.ok(await page.evaluate(() => document.activeElement?.matches('.use-diagnosis')), 'the focus stays')
})
