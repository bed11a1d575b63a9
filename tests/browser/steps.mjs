// What the page's tests do over and over: open it, wait for results, ask the command line, drop files, count pixels.

import assert from 'node:assert/strict'
import { execFileSync } from 'node:child_process'
import { mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, statSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { basename, join } from 'node:path'
import { after, test } from 'node:test'
import { fileURLToPath } from 'node:url'
import { leaving, openPage, stopShared } from './harness.mjs'

export const ROOT = fileURLToPath(new URL('../../', import.meta.url))
const OUTPUT = join(ROOT, 'tests/browser/output')
export const TOLERANCES_MM = [0.01, 0.02, 0.05]

const scratch = mkdtempSync(join(tmpdir(), 'truefeed-page-'))
after(() => rmSync(scratch, { recursive: true }))
after(stopShared)
mkdirSync(OUTPUT, { recursive: true })

/**
 * A test on a page of its own, which must make no console error and send no request elsewhere.
 *
 * @param {string} name
 * @param {(opened: Awaited<ReturnType<typeof openPage>>) => Promise<void>} body
 * @param {{ viewport?: { width: number, height: number }, skip?: string | false, isLong?: boolean, open?: () => Promise<any> }} [options]
 *   `skip`: what is missing and what would provide it; `isLong`: it runs in the full suite only; `open`: opens the page, in
 *   Chromium if nothing else is said
 */
export function pageTest(name, body, { viewport, skip = false, isLong = false, open = () => openPage({ viewport, isShared: true }) } = {}) {
  test(name, { skip: (isLong && leftForAll(name)) || (skip && skipped(skip)), timeout: 300_000 }, async () => {
    const opened = await open()
    reaching(opened.page)
    try {
      await opened.page.waitForSelector('html[data-ready]')
      await body(opened)
      assert.deepEqual(opened.errors, [])
      assert.deepEqual(leaving(opened.requests, opened.origin), [])
    } finally {
      await opened.close()
    }
  })
}

/** A page test that runs in the full suite only. @type {typeof pageTest} */
export const longTest = (name, body, options) => pageTest(name, body, { ...options, isLong: true })

/** A test that opens its pages itself, and runs in the full suite only. @param {string} name @param {{ timeout?: number }} options @param {(context: import('node:test').TestContext) => Promise<void> | void} body */
export const longPlainTest = (name, options, body) => test(name, { ...options, skip: leftForAll(name) }, body)

/** Notes on a line, which `scripts/test` collects, that a check cannot run here. @param {string} reason  what is missing, and what would provide it */
export function skipped(reason) {
  console.log(`skipped: ${reason}`)
  return reason
}

/** Returns why a test of the full suite is skipped, or false where `scripts/test --all` runs. Prints a line that `scripts/test` counts. @param {string} name */
export function leftForAll(name) {
  if (process.env.TRUEFEED_ALL) return false
  console.log(`left for --all: ${name}`)
  return 'full suite only'
}

/** What is done to a control, or asks that it is in sight. */
const GESTURES = /** @type {const} */ (['click', 'fill', 'press', 'focus', 'selectOption', 'check', 'uncheck', 'hover'])
const LOOKS = /** @type {const} */ (['scrollIntoViewIfNeeded', 'screenshot', 'boundingBox'])
/** How a locator comes from another. */
const NARROWED = /** @type {const} */ (['locator', 'first', 'last', 'nth', 'filter'])

/** Has every gesture on this page first open what its control is in, by the buttons that a user has for it. */
export function reaching(page) {
  for (const gesture of GESTURES) {
    const plain = page[gesture].bind(page)
    page[gesture] = async (selector, ...rest) => {
      await reach(page, selector)
      return plain(selector, ...rest)
    }
  }
  const plain = page.locator.bind(page)
  page.locator = (...given) => reachingLocator(page, plain(...given))
  return page
}

/** The same of a locator, and of those that it leads to. */
function reachingLocator(page, locator) {
  for (const gesture of [...GESTURES, ...LOOKS]) {
    const plain = locator[gesture].bind(locator)
    locator[gesture] = async (...given) => {
      await open(page, locator)
      return plain(...given)
    }
  }
  for (const narrow of NARROWED) {
    const plain = locator[narrow].bind(locator)
    locator[narrow] = (...given) => reachingLocator(page, plain(...given))
  }
  return locator
}

/** Opens what the first of these elements is in. */
export const reach = (page, selector) => open(page, page.locator(selector).first())

/** Opens what an element is in: a drawer of the bar, a panel below the picture, what is folded away; a drawer that may lie over it is closed. */
async function open(page, locator) {
  const openers = await locator.evaluate((element) => {
    // If a panel has replaced the element in the meantime, it has no parents any more.
    if (!element.isConnected) return null
    const drawer = element.closest('.drawer:not(:popover-open)')
    const over = document.querySelector('.drawer:popover-open')
    const isOver = over && !over.contains(element) && over.id !== element.closest('[popovertarget]')?.getAttribute('popovertarget')
    const panel = element.closest('#opened > section:not(.open)')
    const folded = element.closest('main :is(#quote, #path, #program, #chart) details:not([open])')
    const isSummary = element.closest('summary')
    return [
      ...(isOver ? [`#${over.id} .close`] : []),
      ...(drawer ? [`.pick[popovertarget="${drawer.id}"]`] : []),
      ...(panel ? [`#more [aria-controls~="${panel.id}"]`] : []),
      ...(folded && !isSummary
        ? [`#${folded.closest('section').id} details${folded.className ? `.${folded.classList[0]}` : ''}:not([open]):has(${element.id ? `#${element.id}` : element.localName}) > summary`]
        : []),
    ]
  })
  if (!openers) return open(page, locator)
  for (const opener of openers) await page.mainFrame().locator(opener).first().click()
}

/** Waits until every row of the table is of the machine and program in sight, and the panels that come later are there. */
export async function computed(page, { later = true } = {}) {
  await page.waitForFunction(
    (later) => {
      if (later && !document.documentElement.dataset.whole) return false
      const rows = [...document.querySelectorAll('#tolerances tbody tr')]
      const stale = document.querySelector('.stale') || !document.querySelector('#progress')?.hidden
      return !stale && rows.length > 0 && rows.every((row) => row.querySelector('data'))
    },
    later,
    { timeout: 120_000 },
  )
}

/** Those of the tolerances that the user chose. */
export const cycleTimes = (page) => page.$$eval('#tolerances tbody tr:not(.programmed) data', (all) => all.map((data) => Number(data.value)))

/** @type {string | undefined} */
let built

/** The command line, of the sources as they are: the one that `TRUEFEED_COMMAND` names, which `scripts/test` has built, or a new one. */
export function binary() {
  if (built) return built
  assertModulesAreCurrent()
  if (process.env.TRUEFEED_COMMAND) return (built = process.env.TRUEFEED_COMMAND)
  execFileSync('cargo', ['build', '--quiet', '--locked', '--bin', 'truefeed', '--profile', 'test'], { cwd: ROOT, stdio: 'inherit' })
  built = join(ROOT, 'target/debug/truefeed')
  return built
}

/** The page is compared with a command of the same sources, or not at all. */
function assertModulesAreCurrent() {
  const sources = readdirSync(join(ROOT, 'src'), { recursive: true })
    .filter((path) => path.endsWith('.rs'))
    .map((path) => join('src', path))
  const time = (path) => statSync(join(ROOT, path)).mtimeMs
  const module = 'www/pkg/truefeed_whole_bg.wasm'
  const later = [...sources, 'Cargo.toml', 'Cargo.lock'].filter((path) => time(module) < time(path))
  assert.deepEqual(later, [], `the page was built before these were changed; run scripts/build`)
}

/** Path of the machine file that the page saves. */
export async function machineOf(page) {
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#machine .save')])
  const machine = join(scratch, 'machine.toml')
  await download.saveAs(machine)
  return machine
}

/**
 * What the command line says about the same program, with the machine file that the page saves: for the tolerances
 * the page begins with, or those given; none leaves it to the program.
 */
export async function predicted(page, program, toleranceList = TOLERANCES_MM) {
  const machine = await machineOf(page)
  const tolerances = toleranceList.flatMap((tolerance) => ['--tolerance', String(tolerance)])
  const args = ['predict', program, '--machine', machine, ...tolerances, '--json']
  return JSON.parse(execFileSync(binary(), args, { encoding: 'utf8', maxBuffer: 1 << 28 }))
}

export async function assertAsPredicted(page, program) {
  const { runs } = await predicted(page, program)
  const times = await cycleTimes(page)
  assert.equal(times.length, runs.length)
  runs.forEach(({ cycle_time_s: expected }, index) => {
    assert.ok(expected > 0)
    assert.ok(Math.abs(times[index] / expected - 1) <= 1e-9, `${times[index]} on the page, ${expected} on the command line`)
  })
}

/** Drops files on an element, as a file manager would. */
export async function drop(page, selector, files) {
  const sent = files.map((file) => ({ name: basename(file), bytes: [...readFileSync(file)] }))
  const transfer = await page.evaluateHandle((all) => {
    const data = new DataTransfer()
    for (const { name, bytes } of all) data.items.add(new File([new Uint8Array(bytes)], name))
    return data
  }, sent)
  await page.dispatchEvent(selector, 'dragenter', { dataTransfer: transfer })
  assert.ok(await page.isVisible('.cover'), 'the page does not say that it takes the file')
  await page.dispatchEvent(selector, 'drop', { dataTransfer: transfer })
  assert.ok(await page.isHidden('.cover'))
}

/** Pixels of the canvas in each curve's colour, which is what the chips show as well, below a part of its height. */
export function pixelsOfCurves(page, below = 0) {
  return page.evaluate((part) => {
    const canvas = document.querySelector('.plot canvas')
    const { width, height } = canvas
    const { data } = canvas.getContext('2d').getImageData(0, Math.round(part * height), width, height)
    return [...document.querySelectorAll('.chip .swatch')].map((swatch) => {
      const wanted = getComputedStyle(swatch).backgroundColor.match(/\d+/g).map(Number)
      let count = 0
      for (let i = 0; i < data.length; i += 4) {
        if (wanted.every((value, channel) => Math.abs(data[i + channel] - value) <= 2)) count += 1
      }
      return count
    })
  }, below)
}

/** Waits until no worker is left. */
export const workersEnded = (page) => Promise.all(page.workers().map((worker) => new Promise((done) => worker.once('close', done))))

/** Waits until all that was to be drawn is drawn, and seen. */
export const frame = (page) =>
  page.evaluate(async () => {
    const { drawn } = await import('/drawing.js')
    const next = () => new Promise((done) => requestAnimationFrame(done))
    // What has come in sight is told at the end of a frame.
    await next()
    await next()
    await drawn()
    await next()
  })

/** Waits until the browser keeps a tab of which `holds` is true; nothing says when it has written it. Programs come by their numbers. */
export async function kept(page, holds) {
  const tabs = () =>
    page.evaluate(
      () =>
        new Promise((resolve) => {
          const asked = indexedDB.open('truefeed', 1)
          asked.onsuccess = () => {
            const found = asked.result.transaction('tabs').objectStore('tabs').getAll()
            found.onsuccess = () => {
              asked.result.close()
              const told = ({ programs, selected, diagnosis }) => ({ programs: programs.map(({ id }) => id), selected, isDiagnosed: Boolean(diagnosis) })
              resolve(found.result.map(told))
            }
          }
        }),
    )
  const end = Date.now() + 30_000
  while (!(await tabs()).some(holds)) assert.ok(Date.now() < end, 'the browser has not written it')
}
export const span = async (page) => {
  await frame(page)
  return (await page.getAttribute('.plot', 'data-span')).split(' ').map(Number)
}
/** Widths of a phone, a laptop and a large screen, with heights. */
const SIZES = [
  [390, 844],
  [1280, 900],
  [1920, 1080],
]
const VIEWS = SIZES.flatMap(([width, height]) => ['light', 'dark'].map((colorScheme) => ({ width, height, colorScheme })))
/** The full suite looks at all views, a push at the phone in the light theme, which has least room, and the laptop in the dark one. */
const LOOKED_AT = process.env.TRUEFEED_ALL ? VIEWS : [VIEWS[0], VIEWS[3]]

/**
 * Looks at the open page in every view of the suite: at no width may it scroll sideways. Restores size and theme at the end.
 * @param {string} name  of the pictures
 * @param {(name: string) => Promise<void>} [look]  what else is to be looked at
 */
export async function atEverySize(page, name, look = (name) => shot(page, name)) {
  const before = page.viewportSize()
  for (const { width, height, colorScheme } of LOOKED_AT) {
    await page.setViewportSize({ width, height })
    await page.emulateMedia({ colorScheme })
    await drawAll(page)
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name} scrolls sideways at ${width} px`)
    await look(`${name}-${width}-${colorScheme}`)
  }
  await page.emulateMedia({ colorScheme: null })
  await page.setViewportSize(before)
  await frame(page)
}

/** Has every canvas drawn at the size and in the theme of now: what is out of sight is drawn when it comes in sight. */
async function drawAll(page) {
  const at = await page.evaluate(() => scrollY)
  const count = await page.locator('canvas').count()
  for (let index = 0; index < count; index += 1) {
    const isThere = await page.evaluate((index) => {
      const canvas = document.querySelectorAll('canvas')[index]
      canvas?.scrollIntoView({ block: 'center' })
      return canvas?.checkVisibility()
    }, index)
    if (isThere) await frame(page)
  }
  await page.evaluate((at) => scrollTo(0, at), at)
  await frame(page)
}

/** Keeps a picture in tests/browser/output, for whoever changes how the page looks: no test compares it. */
export const shot = (page, name) => page.screenshot({ path: join(OUTPUT, `${name}.png`) })
