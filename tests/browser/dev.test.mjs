// `scripts/serve --dev`: an edit shows on the next reload, also in a browser whose service worker kept the last build.

import assert from 'node:assert/strict'
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { chromium } from 'playwright-core'
import { serve } from '../../scripts/serve.mjs'
import { findChromium } from './chromium.mjs'
import { longPlainTest } from './steps.mjs'

/** A page of one file, with a service worker that answers with what it kept, as ours does. */
const PAGE = (text) => `<!doctype html><title>${text}</title><link rel="icon" href="data:,"><script src="page.js"></script>`
const REGISTER = "navigator.serviceWorker.register('sw.js', { updateViaCache: 'none' })"
const KEEPS = `
self.addEventListener('install', (event) => event.waitUntil(caches.open('kept').then((cache) => cache.addAll(['./', 'page.js']))))
self.addEventListener('fetch', (event) => event.respondWith(caches.match(event.request).then((kept) => kept ?? fetch(event.request))))
`

longPlainTest('without the service worker an edit shows on reload, and with it the last build does', { timeout: 120_000 }, async () => {
  const folder = mkdtempSync(join(tmpdir(), 'truefeed-dev-'))
  const edit = (text) => writeFileSync(join(folder, 'index.html'), PAGE(text))
  writeFileSync(join(folder, 'page.js'), REGISTER)
  writeFileSync(join(folder, 'sw.js'), KEEPS)
  edit('built')
  const browser = await chromium.launch({ executablePath: findChromium(), args: ['--no-sandbox'] })
  let server = await serve(0, [folder])
  const port = Number(new URL(server.origin).port)
  try {
    const page = await browser.newPage()
    await page.goto(server.origin)
    await page.evaluate(() => navigator.serviceWorker.ready)
    edit('edited once')
    await page.reload()
    assert.equal(await page.title(), 'built', 'the service worker of this test keeps nothing')

    await server.close()
    server = await serve(port, [folder], { isDev: true })
    await page.reload()
    await page.waitForFunction(() => document.title === 'edited once')
    edit('edited twice')
    await page.reload()
    await page.waitForFunction(() => document.title === 'edited twice')
  } finally {
    await browser.close()
    await server.close()
    rmSync(folder, { recursive: true })
  }
})
