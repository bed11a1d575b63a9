// The quote: what it is made of adds up, follows every entry at once, and leaves as file and on paper.

import assert from 'node:assert/strict'
import { readFileSync } from 'node:fs'
import { atEverySize, computed, longTest, pageTest, shot } from './steps.mjs'

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
  await page.waitForFunction(() => document.querySelector('#quote .tables')?.textContent.includes('Margin on the part'))
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
  await page.waitForFunction(() => document.querySelector('#quote .headline')?.textContent.includes('€'))
})

pageTest('every amount is in sight and they add up to the total', async ({ page }) => {
  await quoted(page)
  const rows = await page.evaluate(() => [...document.querySelector('#quote .tables table').tBodies[0].rows].map((row) => [...row.cells].map((cell) => (cell.firstChild ?? cell).textContent)))
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
  const breaks = await page.evaluate(() => [...document.querySelectorAll('#quote .tables table')[1].tBodies[0].rows].map((row) => [...row.cells].map((cell) => cell.textContent)))
  assert.deepEqual(
    breaks.map(([quantity]) => quantity),
    ['1', '10', '25', '100'],
  )
  const units = breaks.map(([, unit]) => cents(unit))
  assert.deepEqual(
    units,
    [...units].sort((a, b) => b - a),
  )
  assert.match(await page.textContent('#quote .sure'), /±7\.9 %.*Ward et al\./s)

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

longTest('an edit of the machine takes its error away, and the quote says so', async ({ page }) => {
  await quoted(page)
  await page.fill('#field-interpolator-time_constant_s', '0.03')
  await computed(page)
  assert.match(await page.textContent('#quote .sure'), /unknown/)
  assert.match(await page.textContent('#quote .tables table >> nth=1'), /unknown/)
  await page.fill(term('uncertainty_percent'), '4')
  assert.match(await page.textContent('#quote .sure'), /±4\.0 %, as entered/)
  await page.click('#machine .reset')
  await page.fill(term('uncertainty_percent'), '')
  await computed(page)
  assert.match(await page.textContent('#quote .sure'), /±7\.9 %/)
})

longTest('an uncertainty is claimed at the tolerances it was measured at, and nowhere else', async ({ page }) => {
  await quoted(page)
  assert.match(await page.textContent('#quote .sure'), /±7\.9 %/)
  await page.check('#tolerances input[value="20 µm"]')
  assert.match(await page.textContent('#quote .sure'), /not measured at 20 µm\. At 10 µm and 50 µm it was ±7\.9 %/)
  assert.match(await page.textContent('#quote .tables table >> nth=1'), /unknown/)
  await page.check('#tolerances input[value="50 µm"]')
  assert.match(await page.textContent('#quote .sure'), /Cycle time ±7\.9 %/)

  // What is quoted is not forgotten.
  await page.selectOption('#compare .beside', { index: 2 })
  const beside = await page.inputValue('#compare .beside')
  await page.reload()
  await computed(page)
  assert.ok(await page.isChecked('#tolerances input[value="50 µm"]'))
  assert.match(await page.textContent('#quote .on-paper'), /50 µm/)
  assert.equal(await page.inputValue('#compare .beside'), beside)
})

pageTest('a quote of the machine before is not taken away for one of the machine of now', async ({ page }) => {
  await quoted(page)
  const before = await page.textContent('#quote .answer')
  const during = await page.evaluate(() => {
    const field = document.querySelector('#field-interpolator-time_constant_s')
    field.value = '0.05'
    field.dispatchEvent(new Event('input', { bubbles: true }))
    field.dispatchEvent(new Event('change', { bubbles: true }))
    const quantity = document.querySelector('#term-quantity')
    quantity.value = '3'
    quantity.dispatchEvent(new Event('input', { bubbles: true }))
    quantity.dispatchEvent(new Event('change', { bubbles: true }))
    return {
      answer: document.querySelector('#quote .answer').textContent,
      waits: document.querySelector('#quote .waits').textContent,
      open: [...document.querySelectorAll('#quote .exports button')].filter(({ disabled }) => !disabled).length,
    }
  })
  assert.equal(during.answer, before, 'the price of the machine before has settings of now')
  assert.match(during.waits, /Recomputing/)
  assert.equal(during.open, 0)
  await page.emulateMedia({ media: 'print' })
  await computed(page)
  await page.emulateMedia({ media: 'screen' })
  assert.equal(await page.textContent('#quote .waits'), '')
  const { cycle_time_s: time, batch } = JSON.parse((await downloaded(page, '#quote .json')).bytes)
  assert.equal(time, Number(await page.getAttribute('#tolerances data', 'value')))
  assert.equal(batch.quantity, 3)
})

pageTest('every document of a quote says the same facts', async ({ page }) => {
  await quoted(page)
  const { facts, tolerances } = JSON.parse((await downloaded(page, '#quote .json')).bytes)
  assert.deepEqual(
    facts.map(({ name }) => name),
    ['Reference', 'Program', 'Machine', 'Contour tolerance', 'Date', 'Cycle time per part', 'Of that', 'CAM estimate', 'Confidence', 'Remarks on the program'],
  )
  assert.equal(tolerances.length, 3)
  const csv = (await downloaded(page, '#quote .csv')).bytes.toString()
  const html = await page.context().newPage()
  await html.setContent((await downloaded(page, '#quote .html')).bytes.toString())
  const [document, paper] = [await html.textContent('body'), await page.textContent('#quote .on-paper')]
  for (const { name, value } of facts) {
    for (const text of [csv, document, paper]) assert.ok(text.includes(name) && text.includes(value), `${name}: ${value}`)
  }
  for (const { tolerance } of tolerances) assert.match(csv, new RegExp(`\n${tolerance},\\d`))
  assert.match(document, /Price by tolerance/)
  await html.close()
})

longTest('the quote leaves as CSV, JSON and HTML that stands alone', async ({ page, origin }) => {
  await quoted(page)
  const csv = await downloaded(page, '#quote .csv')
  assert.match(csv.name, /^quote-.*\.csv$/)
  assert.match(csv.bytes.toString(), /^fact,value\n.*\n\nitem,basis,paid,time_s,per_hour,amount,of_batch\n/s)
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
  for (const hidden of ['header', '#program', '#chart', '#quote form', '#quote .exports', 'footer']) assert.ok(await page.isHidden(hidden), hidden)
  await shot(page, 'quote-print')
})

pageTest('every chart leaves as SVG and PNG', async ({ page }) => {
  await page.click('#welcome .sample')
  await computed(page)
  // Those of a recording come with the first one.
  const toolbars = await page.$$eval('[role=toolbar]', (all) => all.filter((tools) => !tools.closest('#recording')).map((tools) => tools.querySelectorAll('.picture').length))
  assert.deepEqual(
    toolbars,
    toolbars.map(() => 2),
  )
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
  await page.waitForSelector('#path .places tbody tr', { state: 'attached' })
  const path = await downloaded(page, '#path .picture >> nth=0')
  assert.equal(path.name, 'path.svg')
  // The colours of the legend are there, its ends and the length beside it as well.
  const text = path.bytes.toString()
  assert.ok(4 < new Set(text.match(/<path stroke="#[0-9a-f]{6}"/g)).size, 'the path has colours')
  assert.match(text, /mm\/min<.* mm<\/text>/s)
  assert.ok(5000 < (await downloaded(page, '#path .picture >> nth=1')).bytes.length)
})

longTest('the quote fits every width in both themes, and every control has a name', async ({ page }) => {
  await quoted(page)
  const nameless = await page.$$eval('#quote, #settings, #machine', (sections) =>
    sections.flatMap((section) =>
      [...section.querySelectorAll('button, input, select')]
        .filter((control) => !(control.textContent.trim() || control.labels?.length || control.getAttribute('aria-label')))
        .map((control) => control.outerHTML),
    ),
  )
  assert.deepEqual(nameless, [])
  await page.locator('#quote').scrollIntoViewIfNeeded()
  await atEverySize(page, 'quote', async (name) => {
    await page.locator('#quote').screenshot({ path: `tests/browser/output/${name}.png` })
  })
})
