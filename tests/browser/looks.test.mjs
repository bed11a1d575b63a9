// How the page looks, against pictures that were looked at: at three widths in both themes, a quarter as large, with a tolerance.
// Fonts differ from system to system, so that only the full suite compares. TRUEFEED_KEEP=1 keeps the pictures of now instead.

import assert from 'node:assert/strict'
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs'
import { join } from 'node:path'
import { ROOT, computed, drop, frame, longTest } from './steps.mjs'

const KEPT = join(ROOT, 'tests/browser/looks')
const PROGRAMS = ['10', '20', '30'].map((number) => join(ROOT, `www/samples/bracket-${number}.nc`))
const SIZES = [
  [390, 844],
  [1280, 860],
  [1920, 1080],
]
const SCALE = 0.25
const QUALITY = 0.8
/** A channel of a pixel differs by more than this, of 255, where it is another one, ... */
const OTHER = 48
/** ... and so many pixels of a picture may be others. */
const MOST_OTHERS = 0.02

/** The picture of a page a quarter as large, and how much of it differs from a kept one. */
function compared(page, png, kept) {
  return page.evaluate(
    async ({ png, kept, scale, quality, other }) => {
      const image = async (base64) => createImageBitmap(new Blob([Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0))]))
      const now = await image(png)
      const [width, height] = [Math.round(now.width * scale), Math.round(now.height * scale)]
      const drawn = (picture) => {
        const canvas = new OffscreenCanvas(width, height)
        const context = canvas.getContext('2d')
        context.imageSmoothingQuality = 'high'
        context.drawImage(picture, 0, 0, width, height)
        return { canvas, data: context.getImageData(0, 0, width, height).data }
      }
      const small = drawn(now)
      const bytes = new Uint8Array(await (await small.canvas.convertToBlob({ type: 'image/webp', quality })).arrayBuffer())
      const webp = btoa(bytes.reduce((text, byte) => text + String.fromCharCode(byte), ''))
      if (!kept) return { webp, others: 1 }
      const before = await image(kept)
      if (before.width !== width || before.height !== height) return { webp, others: 1 }
      const { data } = drawn(before)
      let others = 0
      for (let at = 0; at < data.length; at += 4) if ([0, 1, 2].some((channel) => Math.abs(data[at + channel] - small.data[at + channel]) > other)) others += 1
      return { webp, others: (4 * others) / data.length }
    },
    { png: png.toString('base64'), kept, scale: SCALE, quality: QUALITY, other: OTHER },
  )
}

/** Compares the screen at every size with the pictures that are kept. */
async function looksAsKept(page, name) {
  for (const [width, height] of SIZES) {
    await page.setViewportSize({ width, height })
    for (const colorScheme of ['light', 'dark']) {
      await page.emulateMedia({ colorScheme, reducedMotion: 'reduce' })
      await page.evaluate(() => scrollTo(0, 0))
      await frame(page)
      // A picture has another source at another width and in the other theme, which takes a moment.
      await page.waitForFunction(() => [...document.images].every((image) => image.complete || !image.checkVisibility()))
      await frame(page)
      const path = join(KEPT, `${name}-${width}-${colorScheme}.webp`)
      const kept = existsSync(path) ? readFileSync(path).toString('base64') : null
      const { webp, others } = await compared(page, await page.screenshot(), kept)
      if (process.env.TRUEFEED_KEEP) {
        mkdirSync(KEPT, { recursive: true })
        writeFileSync(path, Buffer.from(webp, 'base64'))
      } else {
        assert.ok(kept, `${path} is not kept`)
        assert.ok(others <= MOST_OTHERS, `${name} at ${width} px, ${colorScheme}: ${(100 * others).toFixed(1)} % of it differ`)
      }
    }
  }
}

longTest('an empty page looks as it was kept', ({ page }) => looksAsKept(page, 'empty'))

longTest('a job with its price looks as it was kept', async ({ page }) => {
  await drop(page, 'body', PROGRAMS)
  await computed(page)
  await page.fill('#term-rates-hourly', '85')
  await page.waitForFunction(() => document.querySelector('#quote .headline')?.textContent.includes('€'))
  await page.evaluate(() => document.activeElement?.blur())
  await looksAsKept(page, 'job')
})
