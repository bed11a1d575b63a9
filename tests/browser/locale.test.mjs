// Numbers are written as the user's language does and read as they are written; texts stay English.

import assert from 'node:assert/strict'
import { readFileSync } from 'node:fs'
import { join } from 'node:path'
import { test } from 'node:test'
import { openPage } from './harness.mjs'
import { computed, frame, leftForAll, longPlainTest, reaching, ROOT, shot } from './steps.mjs'

const SAMPLE = join(ROOT, 'www/samples/pocket.nc')
/** Of the languages a push tests the one that differs most from how programs are written. */
const PUSHED = 'de-DE'

for (const [locale, time, constant] of [
  ['de-DE', /^\d+,\d s$/, '0,0255'],
  ['en-US', /^\d+\.\d s$/, '0.0255'],
  ['sv-SE', /^\d+,\d s$/, '0,0255'],
  // Digits of its own are not used: charts and inputs have those from 0 to 9.
  ['ar-EG', /^\d+\.\d s$/, '0.0255'],
]) {
  const name = `numbers in ${locale}`
  test(name, { skip: locale !== PUSHED && leftForAll(name), timeout: 300_000 }, async () => {
    const opened = await openPage({ locale })
    const page = reaching(opened.page)
    try {
      await page.waitForSelector('html[data-ready]')
      const field = '#field-interpolator-time_constant_s'
      assert.equal(await page.inputValue(field), constant)
      // The number of a section is none of that kind.
      assert.match(await page.textContent('#machine .source'), /Sect\. 2\.2\b/)
      await page.setInputFiles('#files', SAMPLE)
      await computed(page)
      const cells = await page.$$eval('#tolerances tbody data', (all) => all.map(({ textContent }) => textContent))
      // The widest tolerance takes less than a minute, which is said in seconds and their tenths.
      assert.match(cells.at(-1), time)
      // So are the numbers of the charts.
      const [download] = await Promise.all([page.waitForEvent('download'), page.click('#chart .picture >> nth=0')])
      const numbers = readFileSync(await download.path(), 'utf8')
        .match(/(?<=>\s*)[\d.,\s\u00a0\u202f]+(?=\s*<\/text>)/g)
        .map((number) => number.trim())
      const written = (value) => new Intl.NumberFormat(new Intl.Locale(locale, { numberingSystem: 'latn' })).format(value)
      assert.ok(numbers.includes(written(2000)) || numbers.includes(written(1000)), numbers.join(' | '))
      const before = await page.textContent('#tolerances tbody')

      // What is shown is what is read: typed again, nothing changes; half of it, the time does.
      await page.fill(field, '')
      await page.fill(field, constant)
      await computed(page)
      assert.equal(await page.textContent('#tolerances tbody'), before)
      assert.equal(await page.locator('#machine [aria-invalid]').count(), 0)
      await page.fill(field, constant.replace('255', '127'))
      await page.waitForFunction((before) => document.querySelector('#tolerances tbody').textContent !== before, before)
      await computed(page)
      // Several numbers in one field, and numbers with names.
      await page.click('#machine details summary')
      const codes = page.locator('#field-times-m_codes')
      await page.fill('#field-times-m_codes', 'M8 = soon')
      assert.equal(await codes.getAttribute('aria-invalid'), 'true')
      await codes.fill(constant.includes(',') ? 'M8 = 0,5, M9 = 1' : 'M8 = 0.5, M9 = 1')
      assert.equal(await codes.getAttribute('aria-invalid'), null)
      // They were read as two entries: one of them is half a second.
      const [saved] = await Promise.all([page.waitForEvent('download'), page.click('#machine .save')])
      assert.match(readFileSync(await saved.path(), 'utf8'), /M8\D+0\.5\D*\s+.*M9\D+1\b/)
      assert.equal(await page.getAttribute('html', 'lang'), 'en')
      assert.deepEqual(opened.errors, [])
      await shot(page, `locale-${locale}`)
    } finally {
      await opened.close()
    }
  })
}

for (const [locale, unclear, plain] of [
  ['en-US', '12,500', '12.500'],
  ['de-DE', '12.500', '12,500'],
]) {
  const name = `thousands in ${locale}`
  test(name, { skip: locale !== PUSHED && leftForAll(name), timeout: 120_000 }, async () => {
    const { page, close } = await openPage({ locale })
    reaching(page)
    try {
      await page.waitForSelector('html[data-ready]')
      const field = '#field-rapid-feed_mm_min'
      const fault = () =>
        page
          .locator('#machine .field', { has: page.locator(field) })
          .locator('.fault')
          .textContent()
      await page.fill(field, unclear)
      assert.match(await fault(), /expected a number in mm\/min, with nothing between thousands, such as 1250/)
      await page.fill(field, plain)
      assert.equal(await fault(), '')
    } finally {
      await close()
    }
  })
}

/** What is read on the page, but for texts of programs and what is typed in files. */
const READ = 'main *:not(code, textarea, option, .listing *, #diagnostics *, #cutting .materials *, script)'
/** A number with a point that sets no three digits apart. */
const POINTED = /(?<![\w./]|Sect\. )\d+\.(\d{1,2}|\d{4,})(?![\w]|\.\w)/

longPlainTest('where a comma is the decimal sign no number on page, pictures and reports has a point, and files for machines have', { timeout: 240_000 }, async () => {
  const opened = await openPage({ locale: 'de-DE' })
  const page = reaching(opened.page)
  const saved = async (button) => {
    const [download] = await Promise.all([page.waitForEvent('download'), page.click(button)])
    return readFileSync(await download.path(), 'utf8')
  }
  try {
    await page.waitForSelector('html[data-ready]')
    await page.click('#welcome .concealed')
    await computed(page)
    await page.fill('#tolerances form input', '12,5')
    await page.press('#tolerances form input', 'Enter')
    await computed(page)
    await page.waitForSelector('#recording .answer .sentence', { state: 'attached' })
    await page.click('#diagnosis .start')
    await page.waitForFunction(() => document.querySelector('#diagnosis .sentence').textContent, null, { timeout: 120_000 })
    await page.locator('#path .places').scrollIntoViewIfNeeded()
    await frame(page)
    const texts = await page.$$eval(READ, (all) => all.flatMap((element) => [...element.childNodes].filter((node) => node.nodeType === 3).map(({ data }) => data.trim())))
    assert.ok(
      texts.some((text) => text === '12,5\u00a0µm' || text === '12,5 µm'),
      'the tolerance is written with a comma',
    )
    assert.deepEqual(
      texts.filter((text) => POINTED.test(text)),
      [],
    )

    const words = (text) => text.replace(/<style.*?<\/style>/gs, '').match(/(?<=>)[^<]+/g)
    const isPointed = (text) => POINTED.test(text) && !/Truefeed/.test(text)
    const svg = words(await saved('#chart .picture >> nth=0'))
    assert.ok(
      svg.some((text) => text.includes('12,5')),
      svg.join(' | '),
    )
    const report = words(await saved('#diagnosis .html'))
    assert.ok(report.some((text) => /\d,\d/.test(text)))
    const quote = words(await saved('#quote .html'))
    assert.ok(quote.some((text) => /\d,\d/.test(text)))
    assert.deepEqual([...svg, ...report, ...quote].filter(isPointed), [])

    assert.equal(typeof JSON.parse(await saved('#diagnosis .json')).fit.cycle_time_error_s.before, 'number')
    assert.match(await saved('#quote .csv'), /\d\.\d/)
    assert.match(await saved('#machine .save'), /= 0\.\d/)
    assert.deepEqual(opened.errors, [])
  } finally {
    await opened.close()
  }
})
