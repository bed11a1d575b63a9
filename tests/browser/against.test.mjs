// Two jobs compared on the page: another revision of a program, another machine, a job that is kept, the file of a job.

import assert from 'node:assert/strict'
import { execFileSync } from 'node:child_process'
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after } from 'node:test'
import { ROOT, atEverySize, binary, computed, drop, frame, longTest, pageTest } from './steps.mjs'

const PROGRAMS = ['bracket-10.nc', 'bracket-20.nc', 'bracket-30.nc'].map((name) => join(ROOT, 'www/samples', name))
const TITLES = ['BRACKET OP10 FACE AND POCKET', 'BRACKET OP20 DRILLING', 'BRACKET OP30 CONTOUR FINISH']
const DWELL_S = 7

const scratch = mkdtempSync(join(tmpdir(), 'truefeed-against-'))
after(() => rmSync(scratch, { recursive: true }))

/** A former revision of the drilling, under a name of its own: it waits before its end, and its lines have other numbers. */
const FORMER = join(scratch, 'drilling-rev-a.nc')
const drilling = readFileSync(PROGRAMS[1], 'utf8').split('\n')
const END = drilling.findIndex((line) => /\bM30\b/.test(line))
writeFileSync(
  FORMER,
  drilling
    .toSpliced(END, 0, `G4 X${DWELL_S}.`)
    .map((line, index) => (/^[GMTXYZ]/.test(line) ? `N${10 * index} ${line}` : line))
    .join('\n'),
)

const ready = (page) =>
  page.waitForFunction(() => /\d:\d\d:\d\d/.test(document.querySelector('#program .total')?.textContent ?? '') && document.querySelector('#progress').hidden, null, { timeout: 120_000 })
const rows = (page, table = '#against .tables') => page.$$eval(`${table} tbody tr`, (all) => all.map((row) => [...row.cells].map((cell) => cell.textContent)))
const sentence = (page) => page.textContent('#against .sentence')
const compared = (page) => page.waitForFunction(() => document.querySelector('#against .sentence').textContent && document.querySelector('#against .tables tbody'), null, { timeout: 120_000 })
const located = (page) => page.waitForFunction(() => document.querySelector('#against .where tbody, #against .where h3 + p:not(.small)'), null, { timeout: 120_000 })
/** Seconds of a written difference such as `−7.0 s`. */
const written = (text) => Number(text.replace('−', '-').replace(/[^\d.-]/g, ''))

/** Opens the job of three operations with a rate, and the panel. */
async function begin(page) {
  await drop(page, 'body', PROGRAMS)
  await ready(page)
  await page.fill('#term-rates-hourly', '60')
  await page.click('#program li:nth-child(2) .choose')
  await page.click('#more [aria-controls="against"]')
}

pageTest('another revision of one program is compared by operation, in price, and line by line', async ({ page }) => {
  await begin(page)
  await page.setInputFiles('#against-files', FORMER)
  await compared(page)
  await located(page)
  assert.match(await sentence(page), /^7\.0 s less per part than drilling-rev-a\.nc \(−.* %\)\. Price per part −€0\.1\d\.$/)
  const table = await rows(page)
  assert.deepEqual(
    table.slice(0, 4).map(([name]) => name),
    [...TITLES, 'Total per part'],
  )
  const differences = table.slice(0, 4).map((row) => written(row[3]))
  assert.deepEqual(
    differences.map((value) => Math.abs(value + 0)),
    [0, DWELL_S, 0, DWELL_S],
    'what did not change takes as long',
  )
  // Only the line that waits is told, though the numbers of all blocks are others.
  const where = await rows(page, '#against .where')
  assert.equal(where.length, 1, JSON.stringify(where))
  assert.deepEqual(where[0].slice(0, 6), [String(END + 1), '–', 'removed', '7.0 s', '–', '−7.0 s'])
  await atEverySize(page, 'against')

  // Another operation is not changed at all, and says so.
  await page.click(`#against .tables button:has-text("${TITLES[0]}")`)
  await page.waitForFunction(() => document.querySelector('#against .where').textContent.includes('Both programs have the same lines'))
  assert.ok((await page.textContent('#bar .job')).length > 0)
})

longTest('a feedrate that was changed shows in the lines after it, on the path and in the charts', async ({ page }) => {
  const text = readFileSync(PROGRAMS[2], 'utf8')
  const faster = text.replace(/F(\d+)/g, (_, feed) => `F${Math.round(Number(feed) / 2)}`)
  assert.notEqual(faster, text)
  const former = join(scratch, 'bracket-30.nc')
  writeFileSync(former, faster)
  await begin(page)
  await page.click('#program li:nth-child(3) .choose')
  await page.setInputFiles('#against-files', former)
  await compared(page)
  await located(page)
  const table = await rows(page)
  assert.ok(written(table[2][3]) < -1, `${table[2]}: a program of that name took the place of its own`)
  const where = await rows(page, '#against .where')
  assert.ok(where.some(([, , kind]) => kind === 'unchanged') && where.some(([, , kind]) => kind === 'changed'), JSON.stringify(where))
  const told = where.reduce((sum, row) => sum + written(row[5]), 0)
  assert.ok(Math.abs(told - written(table[2][3])) < 0.1 * where.length, `${told} of ${table[2][3]}`)
  // The path is coloured by it, and a row leads to its place.
  await page.selectOption('#path .by', 'revised')
  await frame(page)
  assert.match(await page.textContent('#path .legend'), /Slower \(\+\) or faster \(−\) than bracket-30\.nc/)
  const before = await page.getAttribute('#chart .plot', 'data-span')
  await page.click('#against .where tbody button')
  await page.waitForFunction((before) => document.querySelector('#chart .plot').dataset.span !== before, before)
  // Without a comparison there is nothing to colour by.
  await page.selectOption('#against-with', '')
  await page.waitForFunction(() => ![...document.querySelectorAll('#path .by option')].some(({ value }) => value === 'revised'))
})

longTest('the same job on another machine is as the command compares both', async ({ page }) => {
  await begin(page)
  await page.click('#more [aria-controls="against"]')
  await page.click('[popovertarget="jobs"]')
  await page.fill('#job-name', 'Bracket')
  await page.keyboard.press('Tab')
  const save = async (name) => {
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('#jobs .choices:nth-of-type(2) button')])
    await download.saveAs(join(scratch, name))
    return join(scratch, name)
  }
  const own = await save('own.json')
  await page.click('#jobs button.main')
  await page.waitForSelector('#jobs .kept b')
  // The former one is kept; what is open then runs on another machine.
  await page.keyboard.press('Escape')
  const other = await page.$$eval('#preset option', (all) => all.map(({ textContent }) => textContent)[2])
  await page.selectOption('#preset', { label: other })
  await computed(page)
  await ready(page)
  const changed = await save('changed.json')
  await page.click('#jobs .kept button:has-text("Compare")')
  await compared(page)
  const expected = JSON.parse(execFileSync(binary(), ['job', own, '--compare', changed, '--json'], { encoding: 'utf8' }))
  const table = await rows(page)
  assert.equal(expected.operations.length, 3)
  for (const [index, { name, cycle_time_difference_s: by }] of expected.operations.entries()) {
    assert.equal(table[index][0], name)
    assert.ok(Math.abs(written(table[index][3]) - by) <= 0.051, `${table[index]} and ${by}`)
  }
  assert.ok(Math.abs(expected.cycle_time_s.difference) > 1, 'the machines differ')
  // The other way round: what is open, on the machine of before.
  const before = await page.$eval('#machine .preset, #preset', () => document.querySelector('#preset').options[0].textContent)
  await page.selectOption('#against-with', `machine ${before}`)
  await page.waitForFunction((name) => document.querySelector('#against .sentence').textContent.includes(name), before, { timeout: 120_000 })
  assert.deepEqual(
    (await rows(page)).slice(0, 3).map((row) => row[3]),
    table.slice(0, 3).map((row) => row[3]),
  )
})

longTest('a job as a file is compared where its programs are there, and what is neither is refused', async ({ page }) => {
  await begin(page)
  const job = join(scratch, 'two.json')
  const machine = await page.$eval('#preset', (select) => select.options[0].textContent)
  writeFileSync(job, JSON.stringify({ truefeed_job: 1, name: 'Two', machine, tolerance_mm: 0.01, operations: [{ program: 'bracket-10.nc' }, { program: 'bracket-30.nc' }] }))
  await page.setInputFiles('#against-files', job)
  await page.waitForFunction(() => document.querySelector('#against [role=status]').textContent.includes('bracket-10.nc'))
  await page.setInputFiles('#against-files', [job, PROGRAMS[0], PROGRAMS[2]])
  await compared(page)
  const table = await rows(page)
  assert.deepEqual(
    table.slice(0, 3).map((row) => [row[0], row[1] === '–']),
    [
      [TITLES[0], false],
      [TITLES[2], false],
      [TITLES[1], true],
    ],
  )
  assert.match(await sentence(page), /more per part than Two/)
  const picture = join(scratch, 'picture.png')
  writeFileSync(picture, Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0, 0, 0, 0]))
  await page.setInputFiles('#against-files', picture)
  await page.waitForFunction(() => document.querySelector('#against [role=status]').textContent.includes('no program and no job'))
  assert.equal(await page.$('#against .tables table'), null)
  // It comes back by its choice.
  await page.selectOption('#against-with', { label: 'two.json' })
  await compared(page)
})
