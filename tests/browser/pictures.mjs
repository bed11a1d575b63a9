// Takes the pictures of the README and of the empty page from the page itself:  node tests/browser/pictures.mjs. Needs: scripts/build.

import { writeFileSync } from 'node:fs'
import { fileURLToPath } from 'node:url'
import { openPage } from './harness.mjs'

const ROOT = fileURLToPath(new URL('../../', import.meta.url))
/** What an empty page shows of the answer, on a large screen and on a phone: the part of the screen in CSS pixels. */
const ANSWERS = [
  { name: 'answer', viewport: { width: 1280, height: 820 }, clip: { x: 252, y: 54, width: 1028, height: 500 } },
  { name: 'answer-phone', viewport: { width: 390, height: 844 }, clip: { x: 0, y: 54, width: 390, height: 470 } },
]
const QUALITY = 0.4

const { page, close } = await openPage({ viewport: { width: 1280, height: 820 }, locale: 'en-GB' })
try {
  await page.waitForSelector('html[data-ready]')
  await page.click('#welcome .sample')
  await page.fill('#term-quantity', '25')
  await page.fill('#term-rates-hourly', '85')
  await page.fill('#term-set_up_min', '45')
  await page.fill('#term-material', '12.5')
  await page.waitForFunction(() => document.querySelector('#progress').hidden && document.querySelector('#quote .headline')?.textContent.includes('€') && document.documentElement.dataset.whole)
  await page.evaluate(() => document.activeElement?.blur())
  for (const colorScheme of /** @type {const} */ (['light', 'dark'])) {
    await page.emulateMedia({ colorScheme, reducedMotion: 'reduce' })
    for (const { name, viewport, clip } of ANSWERS) {
      await settle(viewport)
      const picture = await page.screenshot({ clip })
      writeFileSync(`${ROOT}www/samples/${name}-${colorScheme}.webp`, await asWebp(picture))
    }
    await settle({ width: 1280, height: 860 })
    await page.screenshot({ path: `${ROOT}docs/pictures/page-${colorScheme}.png` })
    console.log(colorScheme)
  }
} finally {
  await close()
}

/** Waits until the charts are drawn at a size. @param {{ width: number, height: number }} viewport */
async function settle(viewport) {
  await page.setViewportSize(viewport)
  await page.evaluate(() => scrollTo(0, 0))
  await page.click('#path [data-do="fit"]')
  // The charts are drawn in the other colours some frames later.
  await page.waitForTimeout(2000)
}

/** A picture as WebP, which the browser writes. @param {Buffer} png */
async function asWebp(png) {
  const written = await page.evaluate(
    async ([base64, quality]) => {
      const image = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0))]))
      const canvas = new OffscreenCanvas(image.width, image.height)
      canvas.getContext('2d').drawImage(image, 0, 0)
      const bytes = new Uint8Array(await (await canvas.convertToBlob({ type: 'image/webp', quality })).arrayBuffer())
      return btoa(bytes.reduce((text, byte) => text + String.fromCharCode(byte), ''))
    },
    /** @type {[string, number]} */ ([png.toString('base64'), QUALITY]),
  )
  return Buffer.from(written, 'base64')
}
