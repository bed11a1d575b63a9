// No state of the page, of the frame or of the component has a fault that axe knows.

import assert from 'node:assert/strict'
import { createRequire } from 'node:module'
import { readFileSync } from 'node:fs'
import { basename, join } from 'node:path'
import { test } from 'node:test'
import { openPage } from './harness.mjs'
import { computed, pageTest, ROOT } from './steps.mjs'

const AXE = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8')
const SAMPLE = join(ROOT, 'www/samples/pocket.nc')

/** What axe finds, in words. It is brought in by the debugger's side, past the policy of the page. */
async function faults(page) {
  await page.evaluate(AXE)
  const { violations } = await page.evaluate(() => window.axe.run(document, { resultTypes: ['violations'] }))
  return violations.flatMap(({ id, help, nodes }) =>
    nodes.map(({ target, failureSummary }) => `${id} (${help}): ${target.join(' ')}\n  ${failureSummary.replaceAll('\n', '\n  ')}`),
  )
}

async function assertNone(page, state) {
  const found = await faults(page)
  assert.deepEqual(found, [], `${state}:\n${found.join('\n')}`)
}

for (const scheme of ['light', 'dark']) {
  pageTest(`the page has no fault, ${scheme}`, async ({ page }) => {
    await page.emulateMedia({ colorScheme: scheme, reducedMotion: 'reduce' })
    await assertNone(page, 'empty')

    await page.click('#machine details summary')
    await assertNone(page, 'editor of the machine')
    await page.fill('#field-rapid-feed_mm_min', 'fast')
    await assertNone(page, 'a fault in the form')
    await page.click('#history .undo-change')
    await page.click('#machine details summary')

    await page.setInputFiles('#files', SAMPLE)
    await page.waitForSelector('#results .empty, #results tbody')
    await assertNone(page, 'computing')
    await computed(page)
    await page.selectOption('#compare .beside', { index: 2 })
    await page.waitForFunction(() => !document.querySelector('#compare .columns').textContent.includes('…'))
    await page.click('#compare details summary')
    await page.click('#cutting details summary')
    await page.fill('#tolerances input', 'much')
    await page.press('#tolerances input', 'Enter')
    await assertNone(page, 'results')
    await page.hover('#chart .plot')
    await assertNone(page, 'reading in the chart')

    await page.setInputFiles('#files', { name: 'bad.nc', mimeType: 'text/plain', buffer: Buffer.from('G0 X1 Q?\nG1 Y5\nM123\n') })
    await computed(page)
    await assertNone(page, 'remarks')
    await page.click('.programs .remove >> nth=1')
    await assertNone(page, 'removed, with undo')

    await page.click('#settings .copy')
    await page.waitForSelector('#settings .link:not([hidden])')
    await assertNone(page, 'a link')
    await page.evaluate(() => (location.hash = '#settings=nonsense'))
    await page.waitForSelector('#notice .refused:not([hidden])')
    await assertNone(page, 'settings refused')
  })

  pageTest(`recording and diagnosis have no fault, ${scheme}`, async ({ page }) => {
    await page.emulateMedia({ colorScheme: scheme, reducedMotion: 'reduce' })
    await page.click('#welcome .concealed')
    await computed(page)
    await page.waitForSelector('#recording .sentence')
    await assertNone(page, 'recording')
    await page.click('#diagnosis .start')
    await page.waitForSelector('#diagnosis .outcome button', { timeout: 150_000 })
    await assertNone(page, 'diagnosis')
  })
}

test('the frame has no fault', { timeout: 60_000 }, async () => {
  const opened = await openPage({ path: '/embed.html' })
  try {
    await opened.page.waitForSelector('#refusal:not([hidden]), truefeed-quote')
    await assertNone(opened.page, basename(opened.page.url()))
  } finally {
    await opened.close()
  }
})
