// What a first visit takes over the wire, as the project's own server sends it with gzip, and what is only fetched when
// it is asked for.

import assert from 'node:assert/strict'
import { test } from 'node:test'
import { openPage } from './harness.mjs'
import { computed } from './steps.mjs'

/** What it takes now, and a little; 400 kB are wanted. */
const MOST_BYTES = 700_000
const WHOLE = '/pkg/truefeed_whole_bg.wasm'

test('a first visit is small up to its charts, and a recording loads the rest', { timeout: 180_000 }, async (context) => {
  const { page, origin, errors, close } = await openPage({ path: '/icon.svg' })
  try {
    // What the service worker fetches beside the visit, to keep it, is not among them.
    const received = new Map()
    page.on('requestfinished', async (request) => {
      const { responseBodySize, responseHeadersSize } = await request.sizes()
      const { pathname } = new URL(request.url())
      received.set(pathname, (received.get(pathname) ?? 0) + responseBodySize + responseHeadersSize)
    })
    await page.goto(`${origin}/`)
    await page.waitForSelector('html[data-ready]')
    await page.click('#welcome .sample')
    await computed(page)
    const drawn = await page.$eval('#chart canvas', (canvas) => {
      const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height)
      return data.some((value) => value !== 0)
    })
    assert.ok(drawn, 'no chart is drawn')
    await page.waitForLoadState('networkidle')
    const first = [...received.values()].reduce((sum, size) => sum + size, 0)
    context.diagnostic(`a first visit takes ${Math.ceil(first / 1000)} kB, its module ${Math.ceil(received.get('/pkg/truefeed_bg.wasm') / 1000)} kB`)
    assert.ok(received.has('/worker.js') && received.has('/samples/pocket.nc'), [...received.keys()].join(' '))
    assert.ok(!received.has(WHOLE), 'the whole module is fetched before it is asked for')
    assert.ok(first < MOST_BYTES, `a first visit takes ${first} bytes`)

    await page.click('#program .remove')
    await page.click('#welcome .concealed')
    await page.waitForFunction(() => document.querySelector('#recording .answer .sentence'), null, { timeout: 120_000 })
    assert.ok(received.has(WHOLE), 'the recording was compared without the whole module')
    // A picture alone names no icon, so that the browser asks for the usual one.
    assert.deepEqual(errors.filter((error) => !error.includes('/favicon.ico')), [])
  } finally {
    await close()
  }
})
