// A program is read as the control it was written for, and the user may choose another.

import assert from 'node:assert/strict'
import { computed, pageTest, shot, span } from './steps.mjs'

const SIEMENS = ['T1 M6 D1', 'S3000 M3', 'R1=20', 'G0 X0 Y0 Z5', 'MCALL CYCLE81(5,0,2,-10)', 'G1 X=R1 F600', 'MCALL', 'M30']

const time = (page) => page.textContent('#program .programs .about')

pageTest('the dialect is found, shown, and can be chosen by keyboard', async ({ page }) => {
  await page.setInputFiles('#files', {
    name: 'part.mpf',
    mimeType: 'text/plain',
    buffer: Buffer.from(SIEMENS.join('\n')),
  })
  await computed(page)
  assert.equal(await page.textContent('#dialect option:checked'), 'Automatic: Siemens SINUMERIK')
  assert.equal(await page.isHidden('#diagnostics'), true, 'everything is read')
  const found = await time(page)

  await page.focus('#dialect')
  await page.selectOption('#dialect', 'iso')
  await computed(page)
  assert.notEqual(await time(page), found)
  assert.match(await page.textContent('#diagnostics .list'), /not understood/)

  await page.selectOption('#dialect', '')
  await computed(page)
  assert.equal(await time(page), found)
  assert.deepEqual(await span(page), [0, 55], 'the chart shows the whole path again')
  await shot(page, 'dialect')
})
