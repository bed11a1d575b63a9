// No state of the page, of the frame or of the component has a fault that axe knows.

import assert from 'node:assert/strict'
import { createRequire } from 'node:module'
import { readFileSync } from 'node:fs'
import { join } from 'node:path'
import { servePlainPage, servePortal } from '../../examples/embedding/serve.mjs'
import { openPage } from './harness.mjs'
import { ROOT, computed, longPlainTest, longTest, pageTest } from './steps.mjs'

const AXE = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8')
const SAMPLE = join(ROOT, 'www/samples/pocket.nc')

/** What axe finds, in words. It is brought in by the debugger's side, past the policy of the page. */
async function faults(page) {
  await page.evaluate(AXE)
  const { violations } = await page.evaluate(() => window.axe.run(document, { resultTypes: ['violations'] }))
  return violations.flatMap(({ id, help, nodes }) => nodes.map(({ target, failureSummary }) => `${id} (${help}): ${target.join(' ')}\n  ${failureSummary.replaceAll('\n', '\n  ')}`))
}

/** Looks at one state after the other, in both themes; `done` says what was found in any. @param {import('playwright-core').Page} [top]  where `page` is a frame in it */
function looker(page, top = page) {
  const all = []
  return {
    look: async (state) => {
      for (const colorScheme of ['light', 'dark']) {
        await top.emulateMedia({ colorScheme, reducedMotion: 'reduce' })
        all.push(...(await faults(page)).map((fault) => `${state}, ${colorScheme}: ${fault}`))
      }
    },
    done: () => assert.ok(all.length === 0, `\n${all.join('\n')}`),
  }
}

pageTest('the page with results has no fault', async ({ page }) => {
  const { look, done } = looker(page)
  await page.setInputFiles('#files', SAMPLE)
  await computed(page)
  await look('results')
  done()
})

longTest('no state of the page has a fault', async ({ page }) => {
  const { look, done } = looker(page)
  await look('empty')

  await page.click('#machine details summary')
  await look('editor of the machine')
  await page.fill('#field-rapid-feed_mm_min', 'fast')
  await look('a fault in the form')
  await page.click('#history .undo-change')
  await page.click('#machine details summary')
  // The drawer lies over what comes next.
  await page.keyboard.press('Escape')

  await page.setInputFiles('#files', SAMPLE)
  await page.waitForSelector('.has-programs #results')
  await look('computing')
  await computed(page)
  await page.selectOption('#compare .beside', { index: 2 })
  await page.waitForFunction(() => !document.querySelector('#compare .columns').textContent.includes('…'))
  await page.click('#compare details summary')
  await page.click('#chart .behind summary')
  await page.waitForSelector('#chart .behind td')
  await page.click('#cutting details summary')
  await page.waitForSelector('#cutting .entries input')
  await look('a cutting job')
  await page.click('#more [aria-controls="savings"]')
  await page.waitForSelector('#savings tbody button', { timeout: 120_000 })
  await look('savings')
  await page.fill('#tolerances form input', 'much')
  await page.press('#tolerances form input', 'Enter')
  await look('results')
  await page.hover('#chart .plot')
  await look('reading in the chart')
  const buffer = Buffer.from(readFileSync(SAMPLE, 'utf8').replace(/F\d+/, 'F500'))
  await page.setInputFiles('#against-files', { name: 'revision.nc', mimeType: 'text/plain', buffer })
  await page.click('#more [aria-controls="against"]')
  await page.waitForSelector('#against .where tbody')
  await look('two jobs compared')

  await page.setInputFiles('#files', { name: 'bad.nc', mimeType: 'text/plain', buffer: Buffer.from('G0 X1 Q?\nG1 Y5\nM123\n') })
  await page.waitForSelector('#diagnostics:not([hidden]) .list table', { state: 'attached' })
  await page.click('#more [aria-controls="diagnostics"]')
  await computed(page)
  await look('remarks')
  await page.click('.programs .remove >> nth=1')
  await look('removed, with undo')

  await page.click('#settings .copy')
  await page.waitForSelector('#settings .link:not([hidden])')
  await look('a link')
  await page.evaluate(() => (location.hash = '#settings=nonsense'))
  await page.waitForSelector('#notice .refused:not([hidden])')
  await look('settings refused')
  done()
})

longTest('recording and diagnosis have no fault', async ({ page }) => {
  const { look, done } = looker(page)
  await page.click('#welcome .concealed')
  await computed(page)
  await page.waitForSelector('#recording .sentence')
  await look('recording')
  await page.click('#diagnosis .start')
  await page.waitForSelector('#diagnosis .outcome button', { timeout: 150_000 })
  await look('diagnosis')
  done()
})

pageTest('what is refused is announced as refused, and only that', async ({ page }) => {
  const devtools = await page.context().newCDPSession(page)
  await devtools.send('DOM.getDocument')
  const announced = async (selector) => {
    const { result } = await devtools.send('Runtime.evaluate', { expression: `document.querySelector(${JSON.stringify(selector)})` })
    const { nodes } = await devtools.send('Accessibility.getPartialAXTree', { objectId: result.objectId, fetchRelatives: false })
    return nodes[0].properties.find(({ name }) => name === 'invalid')?.value.value ?? 'false'
  }
  await page.setInputFiles('#files', SAMPLE)
  await computed(page)
  await page.click('#machine details summary')
  for (const [selector, wrong, right] of [
    ['#field-rapid-feed_mm_min', 'fast', '20000'],
    ['#field-times-m_codes', 'M8', 'M8 = 1'],
    ['#tolerances form input', 'much', '0.03'],
  ]) {
    for (const [text, expected] of [
      [wrong, 'true'],
      [right, 'false'],
    ]) {
      await page.fill(selector, text)
      await page.press(selector, 'Enter')
      assert.equal(await announced(selector), expected, `${selector}: ${text}`)
    }
  }
})

longPlainTest('components on a page, and a frame in a portal of another origin, have no fault', { timeout: 120_000 }, async () => {
  const [opened, plain, portal] = await Promise.all([openPage({ path: '/embed.html' }), servePlainPage(), servePortal()])
  const { page } = opened
  const { look, done } = looker(page)
  try {
    await page.waitForSelector('#refusal:not([hidden])')
    await look('the frame on its own')
    await page.goto(`${plain.origin}/page.html`)
    await page.waitForFunction(() => document.querySelector('#first').quote)
    await look('two components')
    await page.goto(`${portal.origin}/portal.html?truefeed=${plain.origin}`)
    const frame = await page.waitForSelector('iframe').then((element) => element.contentFrame())
    await page.waitForFunction(() => document.querySelector('#said').textContent.includes('Ready'))
    await page.click('button')
    await frame.waitForFunction(() => document.querySelector('truefeed-quote')?.quote)
    const inFrame = looker(frame, page)
    await inFrame.look('the frame')
    inFrame.done()
    done()
  } finally {
    await Promise.all([opened.close(), plain.close(), portal.close()])
  }
})
