// The quote: what it is made of adds up, follows every entry at once, and leaves as file and on paper.

import assert from 'node:assert/strict'
import { readFileSync } from 'node:fs'
import { computed, pageTest, shot } from './steps.mjs'

const term = (key) => `#term-${key.replaceAll('.', '-')}`

/** The numbers of a cell, in hundredths. */
const cents = (text) => Math.round(Number(text.replaceAll(',', '')) * 100)

async function quoted(page) {
  await page.click('#welcome .sample')
  await computed(page)
  for (const [key, value] of Object.entries({
    quantity: '25',
    breaks: '1; 100; 10',
    set_up_min: '45',
    loading_s: '40',
    'rates.hourly': '82',
    operator_hourly: '46',
    attendance_percent: '30',
    material: '3.75',
    fixed: '60',
    margin_percent: '15',
    reference: 'Bracket <b>7</b>',
  })) {
    await page.fill(term(key), value)
  }
  await page.waitForFunction(() => document.querySelector('#quote .answer')?.textContent.includes('Margin on the part'))
}

async function downloaded(page, selector) {
  const [download] = await Promise.all([page.waitForEvent('download'), page.click(selector)])
  return { name: download.suggestedFilename(), bytes: readFileSync(await download.path()) }
}

pageTest('where nothing has a price, the quote says so and leads to the rate', async ({ page }) => {
  await page.click('#welcome .sample')
  await computed(page)
  assert.equal(await page.textContent('#quote .headline'), 'No price yet')
  assert.doesNotMatch(await page.textContent('#quote .answer'), /0\.00/)
  await page.click('#quote .answer a')
  await page.keyboard.type('85')
  await page.waitForFunction(() => document.querySelector('#quote .headline')?.textContent.includes('EUR'))
})

pageTest('every amount is in sight and they add up to the total', async ({ page }) => {
  await quoted(page)
  const rows = await page.evaluate(() =>
    [...document.querySelector('#quote .answer table').tBodies[0].rows].map((row) => [...row.cells].map((cell) => (cell.firstChild ?? cell).textContent)),
  )
  const sum = rows.pop()
  assert.equal(sum[0], 'Total')
  const column = (index) => rows.reduce((all, row) => all + (row[index] ? cents(row[index]) : 0), 0)
  for (const index of [1, 2, 3]) assert.equal(column(index), cents(sum[index]))
  assert.equal(cents(sum[1]) + 25 * cents(sum[2]), cents(sum[3]))
  for (const row of rows) assert.equal(cents(row[3]), row[1] ? cents(row[1]) : 25 * cents(row[2]), row[0])
  const named = rows.map(([item]) => item)
  for (const item of ['Set-up, machine', 'Set-up, operator', 'Machine, cutting', 'Machine, rapids', 'Operator, during the cycle', 'Material']) {
    assert.ok(named.includes(item), item)
  }
  const breaks = await page.evaluate(() =>
    [...document.querySelectorAll('#quote .answer table')[1].tBodies[0].rows].map((row) => [...row.cells].map((cell) => cell.textContent)),
  )
  assert.deepEqual(breaks.map(([quantity]) => quantity), ['1', '10', '25', '100'])
  const units = breaks.map(([, unit]) => cents(unit))
  assert.deepEqual(units, [...units].sort((a, b) => b - a))
  assert.match(await page.textContent('#quote .sure'), /±7\.9 %.*docs\/paper\.md/s)

  // A rate is the machine's own, wherever it is entered.
  assert.equal(await page.inputValue('#field-rates-hourly'), '82')
  await page.fill(term('quantity'), '0')
  assert.match(await page.textContent('#quote .answer'), /no price while/)
  assert.match(await page.textContent(`${term('quantity')}-fault`), /from 1 to 1000000/)
  await page.fill(term('quantity'), '25')
  await page.reload()
  await page.waitForSelector('html[data-ready]')
  assert.equal(await page.inputValue(term('quantity')), '25')
})

pageTest('an edit of the machine takes its error away, and the quote says so', async ({ page }) => {
  await quoted(page)
  await page.fill('#field-interpolator-time_constant_s', '0.03')
  await computed(page)
  assert.match(await page.textContent('#quote .sure'), /unknown/)
  assert.match(await page.textContent('#quote .answer table >> nth=1'), /unknown/)
  await page.fill(term('uncertainty_percent'), '4')
  assert.match(await page.textContent('#quote .sure'), /±4\.0 %, as entered/)
  await page.click('#machine .reset')
  await page.fill(term('uncertainty_percent'), '')
  await computed(page)
  assert.match(await page.textContent('#quote .sure'), /±7\.9 %/)
})

pageTest('the quote leaves as CSV, JSON and HTML that stands alone', async ({ page, origin }) => {
  await quoted(page)
  const csv = await downloaded(page, '#quote .csv')
  assert.match(csv.name, /^quote-.*\.csv$/)
  assert.match(csv.bytes.toString(), /^item,basis,paid,time_s,per_hour,amount,of_batch\n/)
  const offer = JSON.parse((await downloaded(page, '#quote .json')).bytes)
  assert.equal(offer.batch.quantity, 25)
  const sum = offer.addends.reduce((all, addend) => all + Math.round(100 * addend.of_batch), 0)
  assert.equal(sum, Math.round(100 * offer.batch.total))

  const html = (await downloaded(page, '#quote .html')).bytes.toString()
  const document = await page.context().newPage()
  await document.setContent(html)
  assert.equal(await document.textContent('h1'), 'Bracket <b>7</b>')
  assert.equal(await document.locator('svg').count(), 1)
  assert.ok((await document.locator('svg polyline, svg path').count()) > 0)
  assert.equal(await document.locator('script, link, img[src^="http"]').count(), 0)
  await shot(document, 'quote-document')
  const pdf = await document.pdf({ format: 'A4' })
  assert.equal(pdf.subarray(0, 4).toString(), '%PDF')
  await document.close()
  assert.ok(origin)
})

pageTest('on paper is the quote alone, with its chart', async ({ page }) => {
  await quoted(page)
  await page.evaluate(() => (window.print = () => (window.printed = true)))
  await page.click('#quote .print')
  await page.waitForFunction(() => window.printed)
  assert.equal(await page.locator('#quote .pictures img').count(), 1)
  await page.emulateMedia({ media: 'print' })
  assert.ok(await page.isVisible('#quote .pictures img'))
  assert.ok(await page.isVisible('#quote .on-paper'))
  for (const hidden of ['header', '.side', '#chart', '#quote form', '#quote .exports', 'footer']) assert.ok(await page.isHidden(hidden), hidden)
  await shot(page, 'quote-print')
})

pageTest('every chart leaves as SVG and PNG', async ({ page }) => {
  await page.click('#welcome .sample')
  await computed(page)
  const toolbars = await page.$$eval('[role=toolbar]', (all) => all.map((tools) => tools.querySelectorAll('.picture').length))
  assert.deepEqual(toolbars, toolbars.map(() => 2))
  const svg = await downloaded(page, '#chart .picture >> nth=0')
  assert.equal(svg.name, 'chart.svg')
  assert.match(svg.bytes.toString(), /^<svg .*<polyline/s)
  const png = await downloaded(page, '#chart .picture >> nth=1')
  assert.deepEqual([...png.bytes.subarray(1, 4)], [...Buffer.from('PNG')])
  assert.ok(png.bytes.length > 5000, `${png.bytes.length} bytes`)
  // What is in sight: a stretch is another picture.
  await page.click('#chart [data-do="in"]')
  assert.notDeepEqual((await downloaded(page, '#chart .picture >> nth=0')).bytes, svg.bytes)

  await page.locator('#path').scrollIntoViewIfNeeded()
  await page.waitForSelector('#path .places tbody tr')
  const path = await downloaded(page, '#path .picture >> nth=0')
  assert.equal(path.name, 'path.svg')
  // The colours of the legend are there, its ends and the length beside it as well.
  const text = path.bytes.toString()
  assert.ok(4 < new Set(text.match(/<path stroke="#[0-9a-f]{6}"/g)).size, 'the path has colours')
  assert.match(text, /mm\/min<.* mm<\/text>/s)
  assert.ok(5000 < (await downloaded(page, '#path .picture >> nth=1')).bytes.length)
})

for (const [width, scheme] of [[360, 'light'], [360, 'dark'], [1280, 'light'], [1280, 'dark']]) {
  pageTest(
    `the quote fits ${width} px in ${scheme}, and every control has a name`,
    async ({ page }) => {
      await page.emulateMedia({ colorScheme: scheme })
      await quoted(page)
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth)
      assert.ok(wide <= 0, `${wide} px too wide`)
      const nameless = await page.$$eval('#quote, #settings, #machine', (sections) =>
        sections.flatMap((section) =>
          [...section.querySelectorAll('button, input, select')]
            .filter((control) => !(control.textContent.trim() || control.labels?.length || control.getAttribute('aria-label')))
            .map((control) => control.outerHTML),
        ),
      )
      assert.deepEqual(nameless, [])
      await page.locator('#quote').scrollIntoViewIfNeeded()
      await page.locator('#quote').screenshot({ path: `tests/browser/output/quote-${width}-${scheme}.png` })
    },
    { viewport: { width, height: 900 } },
  )
}
