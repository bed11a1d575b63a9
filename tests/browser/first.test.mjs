// The way of docs/first-visit.md: from an empty browser to a quote for three tolerances, at three widths in both themes.

import assert from 'node:assert/strict'
import { join } from 'node:path'
import { computed, frame, pageTest, ROOT, shot } from './steps.mjs'

const SAMPLE = join(ROOT, 'www/samples/pocket.nc')
const MINUTE_MS = 60_000

for (const [width, height] of [[360, 760], [1280, 900], [2560, 1440]]) {
  for (const scheme of ['light', 'dark']) {
    pageTest(
      `a first visit leads to a quote for three tolerances, ${width} px, ${scheme}`,
      async ({ page }) => {
        const start = performance.now()
        const look = async (step) => {
          await frame(page)
          assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `step ${step} scrolls sideways`)
          await shot(page, `first-${step}-${width}-${scheme}`)
        }
        await page.emulateMedia({ colorScheme: scheme })
        await look(1)
        await page.setInputFiles('#files', SAMPLE)
        await computed(page)
        await look(2)
        await page.click('#results .about a >> text=hourly rate')
        await page.fill('#field-rates-hourly', '85')
        await page.waitForSelector('#results .price')
        await look(3)
        await page.click('header nav >> text=Quote')
        await page.waitForFunction(() => document.querySelector('#quote').getBoundingClientRect().top < innerHeight / 2)
        const prices = await page.$$eval('#quote table', (tables) => {
          const found = tables.find((table) => table.caption?.textContent === 'Price by tolerance')
          return [...found.querySelectorAll('tbody tr')].map((row) => Number(row.children[2].textContent))
        })
        assert.equal(prices.length, 3)
        assert.ok(prices[0] > prices[1] && prices[1] > prices[2] && prices[2] > 0, `${prices}`)
        await look(4)
        assert.ok(performance.now() - start < MINUTE_MS, 'it takes less than a minute')
      },
      { viewport: { width, height } },
    )
  }
}
