// Jobs on the page: several programs dropped, ordered, named, priced together, kept, saved and opened again.

import assert from 'node:assert/strict'
import { readFileSync, writeFileSync, mkdtempSync, mkdirSync, copyFileSync, rmSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after } from 'node:test'
import { deflateRawSync } from 'node:zlib'
import { ROOT, atEverySize, drop, longTest, pageTest, shot } from './steps.mjs'

const NAMES = ['bracket-10.nc', 'bracket-20.nc', 'bracket-30.nc']
const PROGRAMS = NAMES.map((name) => join(ROOT, 'www/samples', name))
/** What the programs call themselves. */
const TITLES = ['BRACKET OP10 FACE AND POCKET', 'BRACKET OP20 DRILLING', 'BRACKET OP30 CONTOUR FINISH']

const scratch = mkdtempSync(join(tmpdir(), 'truefeed-jobs-'))
after(() => rmSync(scratch, { recursive: true }))

/** The operations in sight, in order. */
const operations = (page) => page.$$eval('#program .choose .file', (all) => all.map((one) => one.textContent))

/** Waits until all operations are computed, and have their names. */
const ready = (page, names = TITLES) =>
  page.waitForFunction(
    (names) => {
      const shown = [...document.querySelectorAll('#program .choose .file')].map((one) => one.textContent)
      return shown.join() === names.join() && /\d:\d\d:\d\d/.test(document.querySelector('#program .total')?.textContent ?? '') && document.querySelector('#progress').hidden
    },
    names,
    { timeout: 120_000 },
  )

const price = (page) => page.textContent('#quote .headline b')
/** Times as clocks or as seconds in the texts of elements, s. */
const clocks = (page, selector) =>
  page.$$eval(selector, (all) =>
    all.flatMap(({ textContent }) =>
      [...textContent.matchAll(/(\d+):(\d\d):(\d\d)|(\d+(?:\.\d)?) s\b/g)].map(([, hours, minutes, rest, plain]) =>
        plain ? Number(plain) : Number(hours) * 3600 + Number(minutes) * 60 + Number(rest),
      ),
    ),
  )
const seconds = (clock) =>
  clock
    .match(/(\d+):(\d\d):(\d\d)/)
    .slice(1)
    .reduce((sum, part) => 60 * sum + Number(part), 0)

async function downloaded(page, selector) {
  const [download] = await Promise.all([page.waitForEvent('download'), page.click(selector)])
  return { name: download.suggestedFilename(), text: readFileSync(await download.path(), 'utf8') }
}

pageTest('three programs dropped have a price for 25 parts after six gestures at most', async ({ page }) => {
  await drop(page, 'body', PROGRAMS)
  await ready(page)
  let gestures = 0
  const gesture = async (made) => {
    gestures += 1
    await made
  }
  // Select and type, as anybody would: no gesture opens anything.
  await gesture(page.locator('#term-quantity').click({ clickCount: 3 }))
  await gesture(page.keyboard.type('25'))
  await gesture(page.locator('#term-rates-hourly').click({ clickCount: 3 }))
  await gesture(page.keyboard.type('85'))
  await page.waitForFunction(() => document.querySelector('#quote .headline')?.textContent.includes('€'))
  assert.ok(gestures <= 6, `${gestures} gestures`)
  assert.match(await page.textContent('#quote .of'), /25/)
  const times = await page.$$eval('#program .choose .about', (all) => all.map((one) => one.textContent))
  assert.equal(times.length, 3)
  const total = seconds(await page.textContent('#program .total'))
  const rows = await page.$$eval('#quote .tables details:nth-of-type(3) tbody tr', (all) => all.map((row) => [...row.cells].map((cell) => cell.textContent)))
  const each = rows.slice(0, -1).map((row) => seconds(row[2]))
  assert.equal(each.length, 3)
  assert.ok(Math.abs(each.reduce((sum, one) => sum + one, 0) - total) <= 2, `${each} make ${total}`)
  // The price of the batch is the rate by the time, as nothing else is in it yet.
  const batch = Number((await price(page)).replace(/[^\d.]/g, ''))
  assert.ok(Math.abs(batch - (25 * total * 85) / 3600) < (25 * 85 * 2) / 3600, `${batch} for ${total} s`)
  assert.match(await page.textContent('#quote .lacking'), /set-up/)
  await atEverySize(page, 'job')
})

pageTest('the answer is that of the job: parts on a fixture share tool changes in every total, and the operation in sight stands below', async ({ page }) => {
  await drop(page, 'body', PROGRAMS)
  await ready(page)
  const [alone] = await clocks(page, '#program .total')
  assert.deepEqual(await clocks(page, '#results .time'), [alone], 'the hero is the job')
  const cam = await clocks(page, '#results .cam p')
  const camOfOne = await clocks(page, '#results .one')
  await page.fill('#term-quantity', '25')
  await page.fill('#term-rates-hourly', '60')
  await page.click('[popovertarget="jobs"]')
  await page.fill('#job-fixture', '4')
  await page.keyboard.press('Tab')
  await page.keyboard.press('Escape')
  const [shared] = await clocks(page, '#program .total')
  assert.ok(shared < alone, `${shared} s on a fixture, ${alone} s alone`)
  assert.deepEqual(await clocks(page, '#results .time'), [shared])
  const each = await clocks(page, '#program .choose .about')
  assert.ok(Math.abs(each.reduce((sum, own) => sum + own, 0) - shared) <= 2, `${each} make ${shared}`)
  const quoted = await clocks(page, '#quote .tables details:last-of-type .sum')
  assert.ok(quoted.includes(shared), `the quote says ${quoted}`)
  // What CAM says is the sum of all, and does not depend on a fixture.
  assert.deepEqual(await clocks(page, '#results .cam p'), cam)
  assert.ok(cam[0] > camOfOne[1], `${cam} for all, ${camOfOne} for one`)
  await atEverySize(page, 'job-fixture')
})

longTest('an operation that moves nothing hides neither the price of the job nor its time', async ({ page }) => {
  const still = join(scratch, 'probe-cycle.nc')
  writeFileSync(still, 'G21 G90\nM0\nM30\n')
  await drop(page, 'body', [...PROGRAMS.slice(0, 2), still])
  await page.waitForFunction(() => /\d:\d\d:\d\d/.test(document.querySelector('#program .total')?.textContent ?? '') && document.querySelector('#progress').hidden)
  await page.fill('#term-rates-hourly', '60')
  await page.click('#program li:has-text("probe-cycle") .choose')
  assert.ok(await page.isVisible('#quote .headline'))
  assert.match(await price(page), /€/)
  assert.match(await page.textContent('#results .time'), /\d:\d\d/)
})

pageTest('operations are moved by keys, by buttons and by dragging, and renamed, and all of it is taken back', async ({ page }) => {
  await drop(page, 'body', PROGRAMS)
  await ready(page)
  const total = await page.textContent('#program .total')
  await page.click('#program li:nth-child(1) .choose')
  await page.keyboard.press('Alt+ArrowDown')
  assert.deepEqual(await operations(page), [TITLES[1], TITLES[0], TITLES[2]])
  await page.keyboard.press('Alt+ArrowDown')
  assert.deepEqual(await operations(page), [TITLES[1], TITLES[2], TITLES[0]])
  assert.ok(await page.evaluate(() => document.activeElement?.textContent.includes('OP10')), 'the focus goes with it')
  await page.click('#program .operation .up')
  assert.deepEqual(await operations(page), [TITLES[1], TITLES[0], TITLES[2]])
  await page.dragAndDrop('#program li:nth-child(1)', '#program li:nth-child(2)')
  assert.deepEqual(await operations(page), TITLES)
  assert.equal(await page.textContent('#program .total'), total)

  await page.keyboard.press('F2')
  await page.keyboard.type('Roughing')
  await page.keyboard.press('Enter')
  assert.ok((await operations(page)).includes('Roughing'))
  const renamed = await operations(page)
  await page.keyboard.press('F2')
  await page.keyboard.type('never')
  await page.keyboard.press('Escape')
  assert.deepEqual(await operations(page), renamed)
  for (let change = 0; change < 5; change += 1) await page.click('#history .undo-change')
  assert.deepEqual(await operations(page), TITLES)
  await page.click('#history .redo-change')
  assert.deepEqual(await operations(page), [TITLES[1], TITLES[0], TITLES[2]])
})

longTest('an operation has a machine, a set-up and a loading of its own', async ({ page }) => {
  await drop(page, 'body', PROGRAMS.slice(0, 2))
  await ready(page, TITLES.slice(0, 2))
  await page.fill('#term-rates-hourly', '60')
  await page.click('#program li:nth-child(2) .choose')
  await page.fill('#operation-set_up_min', '30')
  await page.waitForFunction(() => document.querySelector('#quote .headline')?.textContent.includes('€'))
  await page.waitForFunction(() => document.querySelector('#quote .tables').textContent.includes('Set-up, machine'))
  const before = await page.textContent('#program .total')
  const other = await page.$$eval('#operation-machine option', (all) => all.map((one) => one.value))
  await page.selectOption('#operation-machine', other[2])
  await page.waitForFunction((before) => document.querySelector('#program .total').textContent !== before && /\d:\d\d/.test(document.querySelector('#program .total').textContent), before)
  await page.fill('#operation-rates-hourly', '30')
  await page.waitForFunction(() => document.querySelector('#quote .tables').textContent.includes('× 30 per h'))
  assert.match(await page.textContent('#quote .tables'), /30\.0 min × 30 per h/)
  assert.match(await page.textContent('#quote .lacking'), /set-up \(BRACKET OP10/)
})

longTest('an operation has a tolerance of its own, which is taken back, saved and opened', async ({ page }) => {
  await drop(page, 'body', PROGRAMS)
  await ready(page)
  const total = () => page.textContent('#program .total')
  const time = () => page.textContent('#results .time')
  const before = await total()
  await page.click('#program li:nth-child(1) .choose')
  const [first, quoted] = [await time(), await page.textContent('#bar .tolerance .name')]
  await page.selectOption('#operation-tolerance', '0.05')
  await page.waitForFunction((before) => document.querySelector('#program .total').textContent !== before, before)
  const changed = await total()
  assert.ok(seconds(changed) < seconds(before), `${changed} at a wider tolerance, ${before} before`)
  assert.equal(await page.textContent('#bar .tolerance .name'), '50 µm')
  assert.notEqual(await time(), first)
  await page.click('#program li:nth-child(3) .choose')
  assert.equal(await page.textContent('#bar .tolerance .name'), quoted, 'the other operations have that of the job')
  // It stays when the job no longer compares it, and another one is chosen where the times are.
  await page.click('#tolerances tr:has-text("50 µm") .remove')
  await page.click('#program li:nth-child(1) .choose')
  await ready(page)
  assert.equal(await total(), changed)
  await page.click('#results .others button:has-text("20 µm")')
  await page.waitForFunction((changed) => document.querySelector('#program .total').textContent !== changed, changed)
  assert.equal(await page.inputValue('#operation-tolerance'), '0.02')
  assert.ok(seconds(await total()) > seconds(changed))
  for (const expected of ['0.05', '0.05', '']) {
    await page.click('#history .undo-change')
    assert.equal(await page.inputValue('#operation-tolerance'), expected)
  }
  await ready(page)
  assert.equal(await total(), before)

  // The file of the job says it for each operation, and so it opens; a reload keeps it.
  await page.selectOption('#operation-tolerance', '0.05')
  await ready(page)
  await page.click('[popovertarget="jobs"]')
  const saved = await downloaded(page, '#jobs .choices:nth-of-type(2) button')
  assert.deepEqual(
    JSON.parse(saved.text).operations.map(({ tolerance_mm: own }) => own),
    [0.05, 0.01, 0.01],
  )
  await page.keyboard.press('Escape')
  await page.reload()
  await page.waitForSelector('html[data-whole]')
  await ready(page)
  assert.equal(await total(), changed)
  const file = join(scratch, 'tolerances.json')
  writeFileSync(file, saved.text)
  for (let count = 0; count < 3; count += 1) await page.click('#program .remove-selected')
  await drop(page, 'body', [file])
  await ready(page)
  assert.equal(await total(), changed)
})

pageTest('a folder and an archive are gone through, in the order of their numbers', async ({ page }) => {
  const folder = join(scratch, 'part')
  mkdirSync(join(folder, 'deep'), { recursive: true })
  copyFileSync(PROGRAMS[0], join(folder, 'op2.nc'))
  copyFileSync(PROGRAMS[1], join(folder, 'op10.nc'))
  copyFileSync(PROGRAMS[2], join(folder, 'deep/op1.nc'))
  writeFileSync(join(folder, 'drawing.pdf'), '%PDF-1.7\n')
  const session = await page.context().newCDPSession(page)
  const data = { items: [], files: [folder], dragOperationsMask: 1 }
  for (const type of ['dragEnter', 'dragOver', 'drop']) await session.send('Input.dispatchDragEvent', { type, x: 400, y: 400, data })
  await ready(page, [TITLES[2], TITLES[0], TITLES[1]])
  assert.ok(await page.isHidden('#notice .refused'), 'what else is in a folder is nobody’s business')

  for (let count = 0; count < 3; count += 1) await page.click('#program .remove-selected')
  const archive = join(scratch, 'part.zip')
  const text = Buffer.from('Read me\nRun op10 first, then op20.\nClamp with M6 screws.\nZ0 is the top of the stock.\n')
  writeFileSync(
    archive,
    zip([
      ['part/op20.nc', readFileSync(PROGRAMS[1])],
      ['part/op10.nc', readFileSync(PROGRAMS[0])],
      ['part/readme.pdf', Buffer.from('%PDF-1.7\n')],
      ['part/readme.txt', text],
    ]),
  )
  await drop(page, 'body', [archive])
  await ready(page, TITLES.slice(0, 2))
  assert.match(await page.textContent('#notice .refused'), /readme\.txt/, 'a text without blocks is no operation, and the page says so')
  writeFileSync(archive, zip([['part/op20.nc', readFileSync(PROGRAMS[1])]]).subarray(0, 60))
  await drop(page, 'body', [archive])
  await page.waitForFunction(() => document.querySelector('#notice .refused')?.textContent.includes('part.zip'))
})

pageTest('a job is kept, found, copied, saved as a file and opened again', async ({ page }) => {
  await page.click('#welcome .sample-job')
  await ready(page, ['Face and pocket', 'Drill and tap', 'Contour finish'])
  assert.equal(await page.inputValue('#term-quantity'), '25')
  await page.fill('#term-rates-hourly', '85')
  await page.waitForFunction(() => document.querySelector('#quote .headline')?.textContent.includes('€'))
  const before = await price(page)
  await page.click('[popovertarget="jobs"]')
  await page.fill('#job-name', 'Bracket left')
  await page.keyboard.press('Tab')
  await page.click('#jobs button.main')
  await page.waitForSelector('#jobs .kept b')
  await shot(page, 'job-kept')
  const saved = await downloaded(page, '#jobs .choices:nth-of-type(2) button')
  assert.equal(saved.name, 'Bracket-left.job.json')
  const job = JSON.parse(saved.text)
  assert.deepEqual([job.truefeed_job, job.name, job.operations.length], [1, 'Bracket left', 3])
  assert.ok(
    job.operations.every(({ text }) => text.startsWith('%')),
    'with its programs',
  )

  // Another one begins, and the kept one comes back.
  await page.click('#jobs button:has-text("New job")')
  assert.deepEqual(await operations(page), [])
  await page.fill('#job-search', 'no such job')
  assert.equal(await page.$('#jobs .kept b'), null)
  await page.fill('#job-search', 'left drill')
  assert.equal(await page.$('#jobs .kept b'), null, 'names of operations are no names of programs')
  await page.fill('#job-search', 'left bracket-20')
  await page.click('#jobs .kept button >> nth=1')
  await ready(page, ['Face and pocket', 'Drill and tap', 'Contour finish'])
  assert.equal(await price(page), before)
  await page.click('[popovertarget="jobs"]')
  assert.equal(await page.inputValue('#job-name'), 'Copy of Bracket left')

  // The file opens in another tab as it was.
  const file = join(scratch, saved.name)
  writeFileSync(file, saved.text)
  await page.keyboard.press('Escape')
  for (let count = 0; count < 3; count += 1) await page.click('#program .remove-selected')
  await drop(page, 'body', [file])
  await ready(page, ['Face and pocket', 'Drill and tap', 'Contour finish'])
  assert.equal(await price(page), before)
  // Undo takes all of it back.
  await page.click('#history .undo-change')
  assert.deepEqual(await operations(page), [])
})

pageTest('a customer gets prices, the house its costs, and who is shown the result its times', async ({ page }) => {
  await page.click('#welcome .sample-job')
  await ready(page, ['Face and pocket', 'Drill and tap', 'Contour finish'])
  await page.fill('#term-rates-hourly', '85')
  await page.fill('#offer-customer', 'Acme <b>\nTown')
  await page.fill('#offer-tax_percent', '19')
  await page.fill('#company-name', 'Our shop')
  await page.waitForFunction(() => !document.querySelector('#quote .customer').disabled)
  const offer = await downloaded(page, '#quote .customer')
  assert.match(offer.text, /Acme &lt;b&gt;/)
  assert.match(offer.text, /Tax, 19 %/)
  assert.match(offer.text, /Our shop/)
  assert.doesNotMatch(offer.text, /Drill and tap|per h|Set-up|DMG|<script/)
  const costing = await downloaded(page, '#quote .html')
  assert.match(costing.text, /Drill and tap: Machine, cutting/)
  assert.equal(costing.text.match(/<svg/g).length, 3)
  const result = await downloaded(page, '#quote .share')
  assert.match(result.text, /Drill and tap/)
  assert.doesNotMatch(result.text, /€|EUR|Acme|<script/)
  // A document of its own runs as it is, and asks for nothing.
  const shown = await page.context().newPage()
  await shown.setContent(result.text)
  await shown.screenshot({ path: join(ROOT, 'tests/browser/output/job-result.png'), fullPage: true })
  assert.match(await shown.textContent('.headline'), /\d:\d\d:\d\d per part/)
  await shown.close()
  await page.reload()
  await page.waitForSelector('html[data-whole]')
  assert.equal(await page.inputValue('#company-name'), 'Our shop')
})

/** A ZIP archive of files. @param {[string, Buffer][]} files */
function zip(files) {
  const parts = []
  const directory = []
  let at = 0
  for (const [name, bytes] of files) {
    const packed = deflateRawSync(bytes)
    const common = Buffer.alloc(26)
    common.writeUInt16LE(20, 0)
    common.writeUInt16LE(8, 4)
    common.writeUInt32LE(packed.length, 14)
    common.writeUInt32LE(bytes.length, 18)
    common.writeUInt16LE(name.length, 22)
    const entry = Buffer.alloc(46)
    entry.write('PK\x01\x02', 0, 'latin1')
    common.copy(entry, 6)
    entry.writeUInt32LE(at, 42)
    const local = Buffer.concat([Buffer.from('PK\x03\x04', 'latin1'), common, Buffer.from(name), packed])
    directory.push(Buffer.concat([entry, Buffer.from(name)]))
    parts.push(local)
    at += local.length
  }
  const list = Buffer.concat(directory)
  const end = Buffer.alloc(22)
  end.write('PK\x05\x06', 0, 'latin1')
  end.writeUInt16LE(files.length, 8)
  end.writeUInt16LE(files.length, 10)
  end.writeUInt32LE(list.length, 12)
  end.writeUInt32LE(at, 16)
  return Buffer.concat([...parts, list, end])
}
