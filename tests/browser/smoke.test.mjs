// The page loads: its WebAssembly module answers, nothing goes wrong, and nothing is asked of another server.

import assert from 'node:assert/strict'
import { test } from 'node:test'
import { leaving, openPage } from './harness.mjs'

test('the page loads its module, without errors and from its own server alone', async () => {
  const { page, origin, requests, errors, close } = await openPage()
  try {
    await page.waitForLoadState('networkidle')
    assert.deepEqual(errors, [])
    assert.deepEqual(leaving(requests, origin), [])
    assert.ok(
      requests.some((url) => url.endsWith('/pkg/truefeed_bg.wasm')),
      'the module was not loaded',
    )
  } finally {
    await close()
  }
})
