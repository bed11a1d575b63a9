// Finds Firefox and opens the page in it, over WebDriver BiDi. Run as a program it prints the path, or fails if there is none that is
// new enough.

import { execFileSync } from 'node:child_process'
import playwright from 'playwright-core'
import { serve } from '../../scripts/serve.mjs'
import { findExecutable, printIfRun } from './executable.mjs'

const NAMES = ['firefox-esr', 'firefox']
/** The first version whose BiDi has all that playwright-core asks for (`network.addDataCollector`). */
const MIN_VERSION = 143

/** Path of a Firefox that is new enough: $FIREFOX if set, else the first known name on the search path. */
export function findFirefox() {
  const path = findExecutable('FIREFOX', NAMES)
  return path && MIN_VERSION <= versionOf(path) ? path : undefined
}

/** The major version, 0 if it does not tell. @param {string} path */
function versionOf(path) {
  try {
    return Number(/Firefox (\d+)/.exec(execFileSync(path, ['--version'], { encoding: 'utf8' }))?.[1] ?? 0)
  } catch {
    return 0
  }
}

/** Opens the page in a fresh profile; `requests` and `errors` hold what it asked for and what it did wrong. Call `close` in the end. */
export async function openInFirefox({ viewport = { width: 1280, height: 900 } } = {}) {
  const server = await serve(0)
  // Playwright drives a Firefox of its own by another protocol; the one that people have speaks BiDi.
  const browser = await playwright._bidiFirefox.launch({ executablePath: findFirefox() }).catch(async (error) => {
    await server.close()
    throw error
  })
  const close = async () => {
    await browser.close()
    await server.close()
  }
  try {
    const context = await browser.newContext({ viewport, locale: 'en-GB' })
    context.setDefaultTimeout(90_000)
    const [requests, errors] = [[], []]
    context.on('request', (request) => requests.push(request.url()))
    context.on('console', (message) => message.type() === 'error' && errors.push(message.text()))
    context.on('weberror', (error) => errors.push(String(error.error())))
    const page = await context.newPage()
    await page.goto(server.origin)
    return { page, origin: server.origin, requests, errors, close }
  } catch (error) {
    await close()
    throw error
  }
}

printIfRun(import.meta.url, findFirefox)
