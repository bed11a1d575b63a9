// Opens the page in headless Chromium, served from www/ on a free port, and keeps a record of what it does.

import { chromium } from 'playwright-core'
import { serve } from '../../scripts/serve.mjs'
import { findChromium } from './chromium.mjs'

// Without the sandbox, which root may not use; the rest keeps Chromium from asking the network for its own ends.
const FLAGS = ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync']

/** A server of www/, or of another folder, and a browser. @param {string} [folder] */
async function start(folder) {
  const executablePath = findChromium()
  if (!executablePath) throw new Error('no Chromium here; run scripts/setup test')
  const server = await serve(0, folder ? [folder] : undefined)
  const browser = await chromium.launch({ executablePath, args: FLAGS }).catch(async (error) => {
    await server.close()
    throw error
  })
  return { server, browser }
}

/** @param {Awaited<ReturnType<typeof start>>} started */
async function stop({ server, browser }) {
  await browser.close()
  await server.close()
}

/** What the pages of one test file share, once the first of them is opened. @type {ReturnType<typeof start> | undefined} */
let shared

/** Ends what pages have shared. */
export async function stopShared() {
  if (shared) await stop(await shared)
}

/**
 * Opens `path` of the page in a fresh profile. `requests` holds every URL asked for, by the page and its workers,
 * and `errors` every console error, uncaught exception and failed request, both in order and up to date.
 * Call `close` in the end, else the test does not finish.
 *
 * `isShared`: server and browser are those of all such pages, until `stopShared` is called; no service worker is then
 * registered, which would fetch and compile both modules beside each test.
 *
 * @param {{ path?: string, viewport?: { width: number, height: number }, locale?: string, isShared?: boolean, folder?: string }} [options]  `folder`: what is served
 */
export async function openPage({ path = '/', viewport = { width: 1280, height: 900 }, locale, isShared = false, folder } = {}) {
  if (isShared) shared ??= start()
  const started = await (isShared ? shared : start(folder))
  const { server, browser } = started
  const context = await browser.newContext({ viewport, locale, serviceWorkers: isShared ? 'block' : 'allow' })
  const close = () => (isShared ? context.close() : stop(started))

  try {
    // A busy machine is no fault of the page; what never comes is.
    context.setDefaultTimeout(90_000)
    /** @type {string[]} */
    const requests = []
    /** @type {string[]} */
    const errors = []
    context.on('request', (request) => requests.push(request.url()))
    context.on('requestfailed', (request) => {
      const why = request.failure()?.errorText
      // What a reload breaks off is no fault: the rest of the page may still be on its way then.
      if (why !== 'net::ERR_ABORTED') errors.push(`${request.url()}: ${why}`)
    })
    context.on('console', (message) => {
      if (message.type() === 'error') errors.push(`${message.text()} (${message.location().url})`)
    })
    context.on('weberror', (error) => errors.push(String(error.error())))

    const page = await context.newPage()
    await page.goto(server.origin + path)
    return { page, origin: server.origin, requests, errors, close }
  } catch (error) {
    await close()
    throw error
  }
}

/**
 * The URLs that are not of `origin`. Data and blob URLs name bytes that the page has already, not a place.
 *
 * @param {string[]} requests
 * @param {string} origin
 */
export function leaving(requests, origin) {
  return requests.filter((url) => !/^(data|blob):/.test(url) && new URL(url).origin !== origin)
}
