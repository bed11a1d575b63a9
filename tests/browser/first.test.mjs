// The way of docs/quote.md: from an empty browser to a quote for three tolerances, at three widths in both themes.

import assert from 'node:assert/strict'
import { join } from 'node:path'
import { atEverySize, computed, pageTest, ROOT } from './steps.mjs'

const SAMPLE = join(ROOT, 'www/samples/pocket.nc')

pageTest(
  'a first visit leads to a quote for three tolerances, and no step of it scrolls sideways',
  async ({ page }) => {
    await atEverySize(page, 'first-1')
    await page.setInputFiles('#files', SAMPLE)
    await computed(page)
    await atEverySize(page, 'first-2')
    await page.click('#quote a >> text=hourly rate')
    await page.keyboard.type('85')
    await page.waitForFunction(() => document.querySelector('#quote .headline').textContent.includes('€'))
    await atEverySize(page, 'first-3')
    await page.click('#quote .tables summary >> text=tolerance')
    const prices = await page.$$eval('#quote table', (tables) => {
      const found = tables.find((table) => table.caption?.textContent === 'Price by tolerance')
      return [...found.querySelectorAll('tbody tr')].map((row) => Number(row.children[2].textContent))
    })
    assert.equal(prices.length, 3)
    assert.ok(prices[0] > prices[1] && prices[1] > prices[2] && prices[2] > 0, `${prices}`)
    await atEverySize(page, 'first-4')
  },
  { viewport: { width: 360, height: 760 } },
)
