// Settings by link and by file: they restore everything but programs, and what is broken or hostile changes nothing.

import assert from 'node:assert/strict'
import { readFileSync } from 'node:fs'
import { computed, longTest, pageTest, reaching } from './steps.mjs'

const ready = (page) => page.waitForSelector('html[data-ready]')

/** Everything that settings hold, as it stands in the forms. */
const standing = (page) =>
  page.evaluate(() => ({
    fields: [...document.querySelectorAll('[id^="field-"], [id^="term-"]')].filter((field) => 'value' in field).map((field) => [field.id, field.type === 'checkbox' ? field.checked : field.value]),
    tolerances: [...document.querySelectorAll('.chip .label')].map(({ textContent }) => textContent),
  }))

async function copied(page) {
  await page.click('#settings .copy')
  await page.waitForFunction(() => document.querySelector('#settings .said').textContent !== '')
  return page.inputValue('#settings .link')
}

async function filled(page) {
  await page.click('#welcome .sample')
  await computed(page)
  await page.fill('#field-name', 'Mill (of Bob’s) <b>')
  await page.fill('#field-rapid-feed_mm_min', '23456')
  await page.fill('#term-quantity', '40')
  await page.fill('#term-reference', 'A&B #7 "x"')
  await page.fill('#tolerances form input', '33')
  await page.keyboard.press('Enter')
  await computed(page)
}

pageTest('a link restores everything on another browser, and says what it holds', async ({ page, origin }) => {
  await filled(page)
  const before = await standing(page)
  const link = await copied(page)
  assert.match(await page.textContent('#settings .said'), /no program/)
  assert.match(await page.textContent('#settings'), /never a program.*browsers never send/s)
  assert.ok(link.startsWith(`${origin}/#settings=`), link)
  assert.ok(link.length < 1500, `${link.length} characters`)
  assert.ok(!/G1|N10|pocket\.nc/.test(decodeURIComponent(link)))
  assert.doesNotMatch(link.slice(link.indexOf('#') + 1), /[()'"<> ]/)

  const context = await page.context().browser().newContext()
  const other = reaching(await context.newPage())
  const asked = []
  other.on('request', (request) => asked.push(request.url()))
  await other.goto(link)
  await ready(other)
  assert.ok(!asked.some((url) => url.includes('23456')))
  assert.equal(new URL(other.url()).hash, '')
  await other.click('#welcome .sample')
  await computed(other)
  assert.deepEqual(await standing(other), before)
  assert.ok(await other.isVisible('#notice .taken'))
  await context.close()
})

longTest('settings of one’s own wait until they are wanted back', async ({ page }) => {
  await filled(page)
  const link = await copied(page)
  await page.click('#machine .reset')
  await page.fill('#term-quantity', '3')
  await page.fill('#field-times-tool_change_s', '5')
  const own = await standing(page)
  // The page is open already: only the part after # changes.
  await page.evaluate((hash) => (location.hash = hash), link.slice(link.indexOf('#')))
  await page.waitForSelector('#notice .taken', { state: 'visible' })
  assert.equal(await page.inputValue('#field-rapid-feed_mm_min'), '23456')
  await page.reload()
  await ready(page)
  await page.waitForSelector('html[data-whole]')
  assert.equal(await page.inputValue('#term-quantity'), '40')
  await page.click('#notice .back')
  assert.ok(await page.isHidden('#notice .taken'))
  assert.deepEqual((await standing(page)).fields, own.fields)
  await page.reload()
  await ready(page)
  await page.waitForSelector('html[data-whole]')
  assert.ok(await page.isHidden('#notice'))
  assert.deepEqual((await standing(page)).fields, own.fields)
})

longTest('a broken or hostile link is told and changes nothing', async ({ page, origin }) => {
  await page.fill('#field-rapid-feed_mm_min', '11111')
  const own = await standing(page)
  const kept = await page.evaluate(() => ({ ...localStorage }))
  const good = { truefeed: 1, preset: '', machine: {}, tolerances_mm: [0.01], programmed: true, terms: {} }
  const hostile = [
    '',
    '%E0%A4%A',
    '{',
    'null',
    '[]',
    '"text"',
    JSON.stringify({ ...good, truefeed: 99 }),
    JSON.stringify({ ...good, program: 'G1 X1' }),
    JSON.stringify({ ...good, tolerances_mm: [-1] }),
    JSON.stringify({ ...good, tolerances_mm: Array(50).fill(0.01) }),
    JSON.stringify({ ...good, machine: { 'rapid.feed_mm_min': 'fast' } }),
    JSON.stringify({ ...good, machine: { constructor: 1 } }),
    JSON.stringify(good).replace('"machine":{}', '"machine":{"__proto__":{"polluted":1}}'),
    JSON.stringify({ ...good, terms: { quantity: 1e300 } }),
    JSON.stringify({ ...good, preset: { toString: 1 } }),
    '<img src=x onerror=alert(1)>',
    'x'.repeat(300_000),
  ]
  for (const text of hostile) {
    const hash = text.startsWith('%') ? text : encodeURIComponent(text)
    await page.evaluate((part) => (location.hash = `settings=${part}`), hash)
    await page.waitForFunction(() => location.hash === '')
    await page.waitForSelector('#notice .refused', { state: 'visible' })
    assert.match(await page.textContent('#notice .refused span'), /cannot be used: .*Nothing was changed/s, text.slice(0, 80))
    assert.deepEqual(await standing(page), own)
    await page.click('#notice .dismiss')
    assert.ok(await page.isHidden('#notice'))
  }
  assert.deepEqual(await page.evaluate(() => ({ ...localStorage })), kept)
  assert.equal(await page.evaluate(() => ({}).polluted), undefined)

  // So it is when the page is opened by such a link.
  await page.goto('about:blank')
  await page.goto(`${origin}/#settings=%7B%22truefeed%22%3A2%7D`)
  await ready(page)
  assert.match(await page.textContent('#notice .refused'), /version 2/)
  assert.deepEqual((await standing(page)).fields, own.fields)
})

pageTest('a file does the same as a link, by keys alone', async ({ page }) => {
  await page.fill('#field-rapid-feed_mm_min', '23456')
  await page.focus('#settings .copy')
  await page.keyboard.press('Tab')
  const [download] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('Enter')])
  assert.equal(download.suggestedFilename(), 'truefeed-settings.json')
  const text = readFileSync(await download.path(), 'utf8')
  assert.equal(JSON.parse(text).truefeed, 1)
  await page.click('#machine .reset')
  await page.keyboard.press('Tab')
  const open = (body) => page.setInputFiles('#settings-file', { name: 'mine.json', mimeType: 'application/json', buffer: Buffer.from(body) })
  await open(text)
  await page.waitForFunction(() => document.querySelector('#field-rapid-feed_mm_min').value === '23456')
  await page.focus('#notice .stay')
  await page.keyboard.press('Enter')
  assert.ok(await page.isHidden('#notice'))
  await open('{"machine": 1')
  await page.waitForSelector('#notice .refused', { state: 'visible' })
  assert.match(await page.textContent('#notice .refused'), /mine\.json cannot be used/)
  assert.equal(await page.inputValue('#field-rapid-feed_mm_min'), '23456')
})

longTest('settings that are dropped are taken as settings, whatever the file is called', async ({ page }) => {
  await filled(page)
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('.save-settings')])
  const text = readFileSync(await download.path())
  await page.click('#machine .reset')
  await page.setInputFiles('#files', { name: 'shop.txt', mimeType: 'text/plain', buffer: text })
  await page.waitForSelector('#notice .taken', { state: 'visible' })
  assert.equal(await page.inputValue('#field-rapid-feed_mm_min'), '23456')
  assert.equal(await page.locator('#recording .pairs li').count(), 0)
})
