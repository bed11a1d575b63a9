// Machines: presets with their source, kept ones under names, removal with undo, files, and the editor of every parameter.

import assert from 'node:assert/strict'
import { readFileSync } from 'node:fs'
import { computed, longTest, machineOf, pageTest, reach, reaching } from './steps.mjs'

const options = (page, group) => page.$$eval(`#preset optgroup[label="${group}"] option`, (all) => all.map(({ textContent }) => textContent))
const KEPT = 'Kept in this browser'
const chosen = (page) => page.$eval('#preset', (select) => select.selectedOptions[0].textContent)
const openMore = (page) => page.$eval('#machine details', (details) => (details.open = true))

async function reloaded(page) {
  await page.reload()
  await page.waitForSelector('html[data-ready]')
}

pageTest('presets say where their numbers come from and what they are not', async ({ page }) => {
  const names = await options(page, 'Presets')
  assert.ok(names.length >= 4)
  for (const name of names) {
    await page.selectOption('#preset', { label: name })
    assert.match(await page.textContent('#machine .source'), /measured|[Tt]ypical/)
    assert.match(await page.textContent('#machine .source'), /Calibrate|not measured/)
  }
  await page.selectOption('#preset', { label: names[0] })
  assert.match(await page.textContent('#machine .origin'), /within 8 %.*Ward et al\. 2021/)
})

pageTest('a machine is kept under its name, changed, duplicated, removed and brought back', async ({ page }) => {
  await page.fill('#field-name', 'Mill 3')
  await page.fill('#field-times-tool_change_s', '7')
  await page.click('#machine .keep')
  assert.deepEqual(await options(page, KEPT), ['Mill 3'])
  assert.equal(await chosen(page), 'Mill 3')
  assert.ok(await page.isDisabled('#machine .keep'))
  await reloaded(page)
  assert.equal(await chosen(page), 'Mill 3')
  assert.equal(await page.inputValue('#field-times-tool_change_s'), '7')

  await page.fill('#field-times-tool_change_s', '8')
  assert.ok(await page.isVisible('.field.changed #field-times-tool_change_s'))
  await page.click('#machine .keep')
  await page.click('#machine .duplicate')
  assert.deepEqual(await options(page, KEPT), ['Mill 3', 'Mill 3 (2)'])
  assert.equal(await page.inputValue('#field-name'), 'Mill 3 (2)')

  await page.click('#machine .remove')
  assert.deepEqual(await options(page, KEPT), ['Mill 3'])
  await page.click('#machine .undo button')
  assert.deepEqual(await options(page, KEPT), ['Mill 3', 'Mill 3 (2)'])
  assert.equal(await chosen(page), 'Mill 3 (2)')

  // What was changed is undone as well.
  await page.selectOption('#preset', { label: 'Mill 3' })
  assert.equal(await page.inputValue('#field-times-tool_change_s'), '8')
  await page.fill('#field-times-tool_change_s', '9')
  await page.click('#machine .keep')
  await page.click('#machine .undo button')
  await page.click('#machine .reset')
  assert.equal(await page.inputValue('#field-times-tool_change_s'), '8')

  await page.click('#machine .remove')
  await reloaded(page)
  assert.deepEqual(await options(page, KEPT), ['Mill 3 (2)'])
})

pageTest('a machine file comes back as it went, and a broken one is refused with its place', async ({ page }) => {
  await page.fill('#field-name', 'Lathe of <i>Bob</i>')
  await page.fill('#field-rapid-feed_mm_min', '23456')
  const saved = readFileSync(await machineOf(page), 'utf8')
  await page.click('#machine .reset')
  const load = (name, text) => page.setInputFiles('#machine-file', { name, mimeType: 'text/plain', buffer: Buffer.from(text) })
  await load('bob.toml', saved)
  await page.waitForFunction(() => document.querySelector('#field-rapid-feed_mm_min').value === '23456')
  assert.deepEqual(await options(page, KEPT), ['Lathe of <i>Bob</i>'])
  assert.equal(readFileSync(await machineOf(page), 'utf8'), saved)
  await load('bad.toml', saved.replace('filters = 3', 'filtres = 3'))
  await page.waitForFunction(() => document.querySelector('.import-fault').textContent !== '')
  assert.match(await page.textContent('.import-fault'), /bad\.toml.*line \d+, column 1.*interpolator\.filters/)
  assert.equal(await page.inputValue('#field-rapid-feed_mm_min'), '23456')
  assert.equal((await options(page, KEPT)).length, 1)
})

pageTest('a machine file among dropped programs is the machine', async ({ page }) => {
  await page.fill('#field-rapid-feed_mm_min', '23456')
  const saved = readFileSync(await machineOf(page))
  await page.click('#machine .reset')
  await page.setInputFiles('#files', [
    { name: 'part.nc', mimeType: 'text/plain', buffer: Buffer.from('G21 G90 G1 X10 F600\nM30\n') },
    { name: 'mill.toml', mimeType: 'text/plain', buffer: saved },
  ])
  await computed(page)
  assert.equal(await page.inputValue('#field-rapid-feed_mm_min'), '23456')
  assert.equal(await page.locator('#program [role="tab"]').count(), 1)
})

longTest('machines that two tabs keep stay, and what one removes goes', async ({ page }) => {
  const other = reaching(await page.context().newPage())
  await other.goto(page.url())
  await other.waitForSelector('html[data-ready]')
  for (const [tab, name] of [
    [other, 'Mill B'],
    [page, 'Mill A'],
  ]) {
    await tab.fill('#field-name', name)
    await tab.click('#machine .keep')
  }
  await reloaded(other)
  assert.deepEqual((await options(other, KEPT)).sort(), ['Mill A', 'Mill B'])
  await other.selectOption('#preset', { label: 'Mill A' })
  await other.click('#machine .remove')
  await reloaded(page)
  assert.deepEqual(await options(page, KEPT), ['Mill B'])
  await other.close()
})

pageTest('the editor has every parameter with meaning, bounds and neutral value; finds, marks and resets', async ({ page }) => {
  await reach(page, '#preset')
  await openMore(page)
  const fields = await page.$$eval('#machine .field', (all) =>
    all.map((field) => ({
      label: field.querySelector('label').textContent,
      doc: field.querySelector('.doc').textContent,
      hint: field.querySelector('.hint').textContent,
      isNumber: field.classList.contains('number'),
    })),
  )
  assert.ok(fields.length > 90, `${fields.length} parameters`)
  for (const { label, doc, hint, isNumber } of fields) {
    assert.ok(doc.length > 8, label)
    assert.match(hint, isNumber ? /^Neutral: .* · .* to / : /^Neutral: /, label)
  }
  assert.ok((await page.locator('#machine .more legend').count()) > 8)

  const visible = () => page.$$eval('#machine .more .field', (all) => all.filter((field) => field.checkVisibility()).length)
  const all = await visible()
  await page.fill('#machine .search input[type="search"]', 'backlash')
  assert.equal(await visible(), 6)
  assert.match(await page.textContent('#machine .found'), /^6 of/)
  await page.fill('#field-axis-y-backlash_mm', '0.02')
  await page.fill('#machine .search input[type="search"]', '')
  assert.equal(await visible(), all)
  await page.check('#machine .search input[type="checkbox"]')
  assert.ok(await page.isVisible('#field-axis-y-backlash_mm'))
  assert.ok(await page.isHidden('#field-axis-x-backlash_mm'))
  await page.uncheck('#machine .search input[type="checkbox"]')
  await page.getByRole('button', { name: 'Reset Backlash Y to 0' }).click()
  assert.equal(await page.inputValue('#field-axis-y-backlash_mm'), '0')
  assert.equal(await page.evaluate(() => document.activeElement?.id), 'field-axis-y-backlash_mm')
})

longTest('what the browser keeps may be anything', async ({ page }) => {
  for (const text of ['{', 'null', '{"a":1}', '[1, null, {"name": 3}, {"name": "odd", "nothing": [1]}]']) {
    await page.evaluate((kept) => localStorage.setItem('truefeed.machines.1', kept), text)
    await reloaded(page)
    assert.ok((await options(page, 'Presets')).length >= 4)
  }
  assert.deepEqual(await options(page, KEPT), ['odd'])
  await page.selectOption('#preset', { label: 'odd' })
  // What no field shows is left out; what is missing is said where it can be given.
  assert.match(await page.textContent('#field-interpolator-time_constant_s-fault'), /expected a number/)
  await page.click('#machine .remove')
  assert.deepEqual(await options(page, KEPT), [])
  await page.selectOption('#preset', { index: 0 })
  await page.click('#welcome .sample')
  await computed(page)
})

pageTest('what is saved can be read until the browser has read it', async ({ page }) => {
  // Firefox and Safari begin to read after the click: here the page's own timers say when a file is let go.
  await page.evaluate(() => {
    window.revoked = []
    window.waiting = []
    const revoke = URL.revokeObjectURL
    URL.revokeObjectURL = (address) => (window.revoked.push(address), revoke.call(URL, address))
    const wait = window.setTimeout
    window.setTimeout = (what, after, ...rest) => (after > 5000 ? window.waiting.push(what) : wait(what, after, ...rest))
  })
  await machineOf(page)
  assert.deepEqual(await page.evaluate(() => window.revoked), [])
  const revoked = await page.evaluate(() => {
    for (const what of window.waiting) what()
    return window.revoked
  })
  assert.equal(revoked.length, 1)
  assert.match(revoked[0], /^blob:/)
})

const MOVE = { feedrate: 40, length: 60, constant: 0.076, interval: 0.002 }

/** A recording of one straight move along X behind two equal filters: its command is constant, and each filter a moving average. */
function recordedMove({ feedrate, length, constant, interval }) {
  const [commanded, width] = [length / feedrate, Math.round(constant / interval)]
  const mean = (values) => values.map((_, at) => values.slice(Math.max(at - width + 1, 0), at + 1).reduce((sum, value) => sum + value, 0) / width)
  const command = Array.from({ length: Math.round((commanded + 1.2) / interval) }, (_, at) => (0.5 <= at * interval && at * interval < 0.5 + commanded ? feedrate : 0))
  let x = 0
  const rows = mean(mean(command)).map((velocity, at) => `${(at * interval).toFixed(4)},${((x += velocity * interval)).toFixed(5)}`)
  return ['t_s,x_mm', ...rows].join('\n')
}

pageTest('one recorded move gives the filters, with undo, and another recording is refused', async ({ page }) => {
  const before = await page.inputValue('#field-interpolator-time_constant_s')
  const give = (name, text) => page.setInputFiles('#machine-move', { name, mimeType: 'text/csv', buffer: Buffer.from(text) })
  await give('ramp.csv', recordedMove(MOVE))
  await page.waitForFunction(() => document.querySelector('#machine .moved').textContent !== '')
  assert.match(await page.textContent('#machine .moved'), /ramp\.csv: one move of 60\.\d+ mm at 2400 mm\/min, 2 equal filters/)
  const after = Number(await page.inputValue('#field-interpolator-time_constant_s'))
  assert.ok(Math.abs(after - MOVE.constant) < 1e-3, `${after} s`)
  await page.click('#machine .undo button')
  assert.equal(await page.inputValue('#field-interpolator-time_constant_s'), before)
  assert.equal(await page.textContent('#machine .moved'), '', 'what was taken back is not said any more')
  await give('noise.csv', ['t_s,x_mm', ...Array.from({ length: 800 }, (_, at) => `${(0.002 * at).toFixed(3)},${Math.sin(at / 9).toFixed(4)}`)].join('\n'))
  await page.waitForFunction(() => document.querySelector('#machine .import-fault').textContent !== '')
  assert.match(await page.textContent('#machine .import-fault'), /noise\.csv: .*(not one straight move|samples|converge)/)
  assert.equal(await page.inputValue('#field-interpolator-time_constant_s'), before)
})
