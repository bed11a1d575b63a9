// Siege of the page: workers that die, reloads in mid-work, hostile files. What the user had stays.

import assert from 'node:assert/strict'
import { readFileSync } from 'node:fs'
import { join } from 'node:path'
import { ROOT, computed, cycleTimes, kept, longTest, pageTest } from './steps.mjs'

const field = (key) => `#field-${key.replaceAll('.', '-')}`
const names = (page) => page.$$eval('#program .file', (all) => all.map((name) => name.textContent))

/** A program of many short blocks, so that there is time to do something to it. */
function longProgram(name, blocks) {
  const lines = ['G21 G90 G94', 'G0 X0 Y0 Z0', 'F3000']
  for (let i = 1; i <= blocks; i += 1) lines.push(`G1 X${(i * 0.1).toFixed(3)} Y${(Math.sin(i) * 0.2).toFixed(3)}`)
  return { name, mimeType: 'text/plain', buffer: Buffer.from(lines.join('\n')) }
}

/** From the next load on, the first `deaths` workers die after their first message, each `Worker` of the page counted. */
async function mortal(page, deaths) {
  await page.addInitScript((most) => {
    const Immortal = window.Worker
    window.started = 0
    window.Worker = class extends Immortal {
      constructor(...given) {
        super(...given)
        const number = (window.started += 1)
        if (number > most) return
        this.addEventListener('message', (event) => {
          event.stopImmediatePropagation()
          this.terminate()
          this.onerror?.(new ErrorEvent('error', { message: 'out of memory' }))
        })
      }
    }
  }, deaths)
  await page.reload()
  await page.waitForSelector('html[data-ready]')
}

pageTest('files that are chosen while the page is still loading are computed', async ({ page }) => {
  const held = new Promise((resolve) => page.route('**/main.js', resolve))
  await page.reload({ waitUntil: 'commit' })
  await page.waitForSelector('#machine-file', { state: 'attached' })
  await page.setInputFiles('#files', longProgram('part.nc', 20))
  await page.setInputFiles('#machine-file', { name: 'mill.toml', mimeType: '', buffer: readFileSync(join(ROOT, 'tests/data/machines/generic.toml')) })
  const script = await held
  await script.continue()
  await computed(page)
  assert.deepEqual(await names(page), ['part.nc'])
  assert.equal(await page.inputValue('#field-name'), 'a machine')
})

longTest('a worker that dies is restarted, and the page computes what it was asked for', async ({ page }) => {
  const program = longProgram('part.nc', 2000)
  await page.setInputFiles('#files', program)
  await computed(page)
  const times = await cycleTimes(page)

  await page.click('#program .remove')
  await mortal(page, 1)
  await page.setInputFiles('#files', program)
  await computed(page)
  assert.ok(1 < (await page.evaluate(() => window.started)), 'another worker was started')
  assert.deepEqual(await cycleTimes(page), times)
  assert.ok(await page.isHidden('#failure'))
})

pageTest('what kills worker after worker is said, and nothing of the user’s is lost', async ({ page }) => {
  await mortal(page, 2)
  await page.fill(field('rates.hourly'), '72')
  await page.setInputFiles('#files', [longProgram('first.nc', 500)])
  await page.waitForSelector('#failure', { state: 'visible' })
  assert.match(await page.textContent('#failure'), /first\.nc could not be simulated: out of memory/)
  assert.deepEqual(await names(page), ['first.nc'])
  assert.equal(await page.inputValue(field('rates.hourly')), '72')

  // Two died; a third is started for what is asked next.
  await page.setInputFiles('#files', [longProgram('second.nc', 500)])
  await computed(page)
  assert.deepEqual(await names(page), ['first.nc', 'second.nc'])
  assert.ok(2 < (await page.evaluate(() => window.started)))
})

longTest('a page reloaded in mid-work goes on where it was', async ({ page }) => {
  await page.fill(field('times.tool_change_s'), '7')
  await page.setInputFiles('#files', [longProgram('one.nc', 1000), longProgram('two.nc', 120_000)])
  await page.waitForSelector('#progress', { state: 'visible' })
  await page.waitForFunction(() => document.querySelectorAll('#program .file').length === 2)
  await page.click('.choose >> nth=1')
  await kept(page, ({ programs, selected }) => selected === programs[1])
  assert.ok(await page.isVisible('#progress'), 'it is still at work')
  await page.reload()
  await page.waitForSelector('html[data-ready]')
  assert.deepEqual(await names(page), ['one.nc', 'two.nc'])
  assert.equal(await page.$eval('.choose[aria-selected="true"] .file', (name) => name.textContent), 'two.nc')
  assert.equal(await page.inputValue(field('times.tool_change_s')), '7')
  await computed(page)
  assert.ok((await cycleTimes(page)).every((time) => time > 0))
})

pageTest('recordings come back with their programs, and what was taken out does not', async ({ page }) => {
  await page.setInputFiles('#files', [longProgram('kept.nc', 50), longProgram('gone.nc', 50)])
  const rows = Array.from({ length: 60 }, (_, i) => `${(i * 0.01).toFixed(2)},${(i * 0.05).toFixed(3)},0,0`)
  const log = { name: 'kept.csv', mimeType: 'text/csv', buffer: Buffer.from(`t_s,x_mm,y_mm,z_mm\n${rows.join('\n')}\n`) }
  await page.setInputFiles('#files', log)
  await page.waitForFunction(() => document.body.classList.contains('has-recording'))
  await page.click('#program li:has(.file:text-is("gone.nc")) .remove')
  await computed(page)
  await page.reload()
  await page.waitForSelector('html[data-ready]')
  assert.deepEqual(await names(page), ['kept.nc'])
  assert.ok(await page.evaluate(() => document.body.classList.contains('has-recording')))
})

pageTest('another tab begins with nothing of this one', async ({ page, origin }) => {
  await page.setInputFiles('#files', longProgram('mine.nc', 50))
  await computed(page)
  const other = await page.context().newPage()
  await other.goto(origin)
  await other.waitForSelector('html[data-ready]')
  assert.deepEqual(await names(other), [])
})

longTest('a duplicated tab goes on with a copy, and neither changes what the other has', async ({ page }) => {
  await page.setInputFiles('#files', [longProgram('a.nc', 50)])
  await computed(page)
  await kept(page, ({ programs }) => programs.length === 1)
  const name = (tab) => tab.evaluate(() => sessionStorage.getItem('truefeed.tab'))
  const before = await name(page)

  // A window that is opened by script begins with the session of its opener, as a duplicated tab does.
  const [copy] = await Promise.all([page.waitForEvent('popup'), page.evaluate(() => void window.open(location.href))])
  await copy.waitForSelector('html[data-ready]')
  assert.deepEqual(await names(copy), ['a.nc'])
  assert.notEqual(await name(copy), before)
  await copy.click('#program .remove')
  await copy.setInputFiles('#files', [longProgram('d.nc', 50)])
  await computed(copy)
  await kept(copy, ({ programs }) => programs.length === 1 && programs[0] > 1)

  for (const [tab, expected] of [
    [page, 'a.nc'],
    [copy, 'd.nc'],
  ]) {
    const own = await name(tab)
    await tab.reload()
    await tab.waitForSelector('html[data-ready]')
    assert.deepEqual(await names(tab), [expected])
    assert.equal(await name(tab), own, 'a tab that is loaded again keeps its name')
  }
})

pageTest('hostile files leave a page that works', async ({ page }) => {
  const hostile = [
    ['empty.nc', Buffer.alloc(0)],
    ['zeros.nc', Buffer.alloc(100_000)],
    ['noise.nc', Buffer.from(Uint8Array.from({ length: 50_000 }, (_, i) => (i * 7919 + (i >> 3)) % 256))],
    ['<img src=x onerror=alert(1)>.nc', Buffer.from('G1 X10 F100\n(<script>alert(1)</script>)\nG1 X#<<b>>\n')],
  ]
  await page.setInputFiles(
    '#files',
    hostile.slice(0, 3).map(([name, buffer]) => ({ name, mimeType: 'text/plain', buffer })),
  )
  await page.waitForFunction(() => document.querySelector('#progress')?.hidden)
  await page.setInputFiles(
    '#files',
    hostile.slice(3).map(([name, buffer]) => ({ name, mimeType: 'text/plain', buffer })),
  )
  await computed(page)
  assert.equal(await page.$('#program img'), null)
  await page.setInputFiles('#files', longProgram('after.nc', 100))
  await computed(page)
  assert.ok((await cycleTimes(page)).every((time) => time > 0))
  assert.ok(await page.isHidden('#failure'))
})

longTest('a loop that runs to its bound is quoted and drawn, and the chart says what its curve leaves out', async ({ page }) => {
  const note = '#chart .note'
  await page.setInputFiles('#files', longProgram('ordinary.nc', 500))
  await computed(page)
  assert.equal(await page.textContent(note), '')
  const endless = 'o1 repeat [100000]\no2 repeat [100000]\nG91 G1 X1 F1000\nY1\nX-1\nY-1\no2 endrepeat\no1 endrepeat\nM2\n'
  await page.setInputFiles('#files', { name: 'endless.ngc', mimeType: 'text/plain', buffer: Buffer.from(endless) })
  await page.waitForFunction((note) => document.querySelector(note)?.textContent, note, { timeout: 250_000 })
  assert.match(await page.textContent(note), /one point every 0\.\d+ s/)
  assert.ok(await page.isHidden('#failure'))
})
