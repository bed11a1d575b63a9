// The page's state is one document: every change of it can be taken back, once and no more, and nothing is kept for what is gone.

import assert from 'node:assert/strict'
import { readFileSync } from 'node:fs'
import { join } from 'node:path'
import ts from 'typescript'
import { ROOT, computed, longTest, pageTest } from './steps.mjs'

const SAMPLE = join(ROOT, 'www/samples/pocket.nc')
const STANDIN = join(ROOT, 'www/samples/standin.nc')
const undo = (page) => page.keyboard.press('Control+z')
const names = (page) => page.$$eval('.choose .file', (all) => all.map(({ textContent }) => textContent))

longTest('a removal that was taken back is not taken back again by its own line', async ({ page }) => {
  await page.setInputFiles('#files', [SAMPLE, STANDIN])
  await computed(page)
  const before = await names(page)
  await page.locator('.programs .remove').first().click()
  await page.focus('.choose[aria-selected=true]')
  await undo(page)
  assert.deepEqual(await names(page), before)
  assert.ok(await page.isHidden('#program .undo'), 'there is nothing left that the line could take back')
  await page.evaluate(() => document.querySelector('#program .undo button').click())
  assert.deepEqual(await names(page), before)
})

pageTest('how a program is read, the tolerance that is quoted and the machines that are kept are taken back as all else', async ({ page }) => {
  await page.setInputFiles('#files', SAMPLE)
  await computed(page)
  const away = () => page.focus('.choose')

  await page.selectOption('#dialect', 'siemens')
  await away()
  await undo(page)
  assert.equal(await page.inputValue('#dialect'), '')

  await page.check('#tolerances input[value="50 µm"]')
  await away()
  await undo(page)
  assert.ok(await page.isChecked('#tolerances input[value="10 µm"]'))

  await page.fill('#field-name', 'Mill 3')
  await page.click('#machine .keep')
  const kept = () => page.$$eval('#preset optgroup:nth-of-type(2) option', (all) => all.map(({ textContent }) => textContent))
  assert.deepEqual(await kept(), ['Mill 3'])
  await page.click('#machine .remove')
  assert.deepEqual(await kept(), [])
  await away()
  await undo(page)
  assert.deepEqual(await kept(), ['Mill 3'])
  assert.equal(await page.$eval('#preset', (select) => select.selectedOptions[0]?.textContent), 'Mill 3')
  await page.reload()
  await page.waitForSelector('html[data-ready]')
  assert.deepEqual(await kept(), ['Mill 3'])
})

longTest('which program a recording is of, and whether it is used, are taken back', async ({ page }) => {
  await page.setInputFiles('#files', [SAMPLE, STANDIN, join(ROOT, 'www/samples/standin.csv')])
  await page.waitForFunction(() => document.querySelector('#recording .pairs select')?.selectedOptions[0]?.textContent === 'standin.nc', null, { timeout: 120_000 })
  const of = () => page.$eval('#recording .pairs select', (select) => select.selectedOptions[0].textContent)
  assert.equal(await of(), 'standin.nc')
  await page.selectOption('#recording .pairs select', { label: 'pocket.nc' })
  await page.focus('.choose[aria-selected=true]')
  await undo(page)
  assert.equal(await of(), 'standin.nc')
  await page.uncheck('#recording .use input')
  await page.focus('.choose[aria-selected=true]')
  await undo(page)
  assert.ok(await page.isChecked('#recording .use input'))
})

longTest('what was computed of a program goes with it', async ({ page }) => {
  const lines = ['G21 G90 G94', 'F3000', ...Array.from({ length: 60_000 }, (_, i) => `G1 X${(i * 0.1).toFixed(3)} Y${(i % 7) * 0.2}`)]
  const devtools = await page.context().newCDPSession(page)
  /** Bytes in the columns of runs on the page; the browser finds no arrays, but the tables that hold runs. */
  const held = async () => {
    await devtools.send('HeapProfiler.collectGarbage')
    const { result: prototype } = await devtools.send('Runtime.evaluate', { expression: 'Map.prototype' })
    const { objects } = await devtools.send('Runtime.queryObjects', { prototypeObjectId: prototype.objectId })
    const { result } = await devtools.send('Runtime.callFunctionOn', {
      objectId: objects.objectId,
      functionDeclaration: `function () {
        const columns = this.flatMap((map) => [...map.values()]).flatMap((run) => Object.values(run?.columns ?? {}))
        return columns.reduce((sum, { byteLength }) => sum + (byteLength ?? 0), 0)
      }`,
      returnByValue: true,
    })
    await devtools.send('Runtime.releaseObject', { objectId: objects.objectId })
    return result.value
  }
  await page.setInputFiles('#files', SAMPLE)
  await computed(page)
  const before = await held()
  await page.setInputFiles('#files', { name: 'long.nc', mimeType: 'text/plain', buffer: Buffer.from(lines.join('\n')) })
  await page.waitForFunction(() => document.querySelector('.choose[aria-selected=true] .file')?.textContent === 'long.nc')
  await computed(page)
  const most = await held()
  assert.ok(before + 1e6 < most, `${before} bytes became ${most}`)
  await page.focus('.choose[aria-selected=true]')
  await page.keyboard.press('Delete')
  await computed(page)
  let after = most
  // What still waits to be drawn holds it for some frames.
  for (let tries = 0; tries < 20 && before + 0.1 * (most - before) < after; tries += 1) {
    await page.waitForTimeout(250)
    after = await held()
  }
  assert.ok(after < before + 0.1 * (most - before), `${after} of ${most} bytes are still held, ${before} before it came`)
  await page.click('#program .undo button')
  await computed(page)
  // A program is called by its title where it has one.
  assert.deepEqual(await names(page), ['POCKET 80 X 50, R8, WITH AN ENGRAVED WAVE AND FOUR HOLES', 'long.nc'])
})

/** The keys of a shape in types.js, by its name; those that may be missing end in “?”. */
function shapes() {
  const source = ts.createSourceFile('types.js', readFileSync(join(ROOT, 'www/types.js'), 'utf8'), ts.ScriptTarget.ES2022, true)
  const found = new Map()
  const literal = (node) => node.members.map((member) => member.name.getText() + (member.questionToken ? '?' : ''))
  const keysOf = (type) => {
    if (!type) return []
    if (ts.isTypeLiteralNode(type)) return literal(type)
    if (ts.isIntersectionTypeNode(type)) return type.types.flatMap(keysOf)
    return ts.isTypeReferenceNode(type) ? (found.get(type.typeName.getText()) ?? []) : []
  }
  for (const doc of source.endOfFileToken.jsDoc ?? source.statements.flatMap((statement) => statement.jsDoc ?? [])) {
    for (const tag of doc.tags ?? []) {
      if (!ts.isJSDocTypedefTag(tag)) continue
      const { typeExpression: shape } = tag
      const keys = shape && ts.isJSDocTypeLiteral(shape) ? (shape.jsDocPropertyTags ?? []).map((own) => own.name.getText() + (own.isBracketed ? '?' : '')) : keysOf(shape?.type)
      found.set(tag.name.getText(), keys)
    }
  }
  return found
}

pageTest('results have the shapes that the page believes them to have', async ({ page }) => {
  const known = shapes()
  const found = await page.evaluate(async () => {
    const [{ Engine }, { confinedWorker }, { wholeModule }, { form }] = await Promise.all(['/engine.js', '/confined.js', '/module.js', '/pkg/truefeed.js'].map((path) => import(path)))
    const engine = new Engine(await wholeModule(), confinedWorker, wholeModule)
    const program = await (await fetch('/samples/pocket.nc')).blob()
    const { fields, presets } = JSON.parse(form())
    const got = {}
    await engine.simulate(
      { program, machine: JSON.stringify(presets[0].values), dialect: null, columns: [0.01], labels: ['10 µm'] },
      { stage() {}, program: (summary) => (got.ProgramSummary = summary), run: (_, { summary }) => (got.RunSummary = summary) },
    )
    engine.end()
    const run = got.RunSummary
    const all = {
      ...got,
      Breakdown: run.breakdown,
      Functions: run.breakdown.other,
      Operation: run.operations[0],
      Tool: run.tools[0],
      Lost: run.lost,
      LostAt: run.lost.places[0],
      Place: run.beyond_tolerance[0],
      Parameter: fields[0],
      Preset: presets[0],
    }
    return Object.fromEntries(Object.entries(all).map(([name, value]) => [name, Object.keys(value)]))
  })
  for (const [name, keys] of Object.entries(found)) {
    const believed = known.get(name)
    assert.ok(believed?.length > 0, `types.js has no ${name}`)
    const lacking = believed.filter((key) => !key.endsWith('?') && !keys.includes(key))
    assert.deepEqual(lacking, [], `${name} has ${keys}`)
  }
})

pageTest('what is announced is not said again while an entry is typed, and the focus stays', async ({ page }) => {
  await page.setInputFiles('#files', SAMPLE)
  await computed(page)
  await page.evaluate(() => {
    window.told = []
    const note = (records) => window.told.push(...records.map(({ target }) => target.parentElement?.className ?? target.className))
    for (const live of document.querySelectorAll('#results [aria-live], #results .others, #tolerances .table'))
      new MutationObserver(note).observe(live, { childList: true, subtree: true, characterData: true })
  })
  await page.fill('#term-quantity', '2')
  await page.fill('#term-quantity', '25')
  await page.fill('#term-set_up_min', '30')
  assert.deepEqual(await page.evaluate(() => window.told), [])
  assert.equal(await page.evaluate(() => document.activeElement.id), 'term-set_up_min')
})

pageTest('every word that a script says is one of the texts', async ({ page }) => {
  // The texts are marked, and what is read without a mark was written elsewhere.
  const marked = (source) =>
    `${source}\nfor (const group of Object.values(say)) for (const [name, text] of Object.entries(group)) group[name] = typeof text === 'string' ? '⟦' + text.replace(/^⟦|⟧$/g, '') + '⟧' : (...all) => '⟦' + text(...all) + '⟧'\n`
  for (const name of ['texts.js', 'texts_later.js'])
    await page.route(`**/${name}`, (route) => route.fulfill({ contentType: 'text/javascript', body: marked(readFileSync(join(ROOT, 'www', name), 'utf8')) }))
  await page.reload()
  await page.waitForSelector('html[data-ready]')
  await page.setInputFiles('#files', { name: 'x.nc', mimeType: 'text/plain', buffer: Buffer.from('G21 G90\nT1 M6\nG0 X5\nG1 X50 F500\nM123\nT2 M6\nG1 Y5\nT1 M6\nG1 X0\n') })
  await computed(page)
  await page.focus('#chart .plot')
  await page.keyboard.press('Shift+ArrowRight')
  const said = await page.evaluate(() => {
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT)
    const found = []
    for (let node = walker.nextNode(); node; node = walker.nextNode()) if (!node.parentElement.closest('script, style, noscript, code, .fields, .list, .places')) found.push(node.textContent)
    return found.map((text) => text.replace(/⟦.*?⟧+/gs, ''))
  })
  const words = /\b(operations?|errors?|warnings?|notes?|rapid|programmed|predicted|chip)\b/
  // What a form, a remark or a place says of a program is Rust's.
  assert.ok(said.length > 100)
  assert.deepEqual(
    said.filter((text) => words.test(text) && text.length < 60),
    [],
  )
})
