// Compresses the files of a folder as well as brotli can, beside them:  node scripts/compress.mjs FOLDER
//
// It takes seconds a file, so that the build does it once and a server sends FILE.br in the place of FILE.

import { readFile, readdir, stat, writeFile } from 'node:fs/promises'
import { join } from 'node:path'
import { argv } from 'node:process'
import { fileURLToPath } from 'node:url'
import { promisify } from 'node:util'
import { brotliCompress, constants } from 'node:zlib'

const TEXTS = /\.(css|csv|html|js|json|nc|svg|toml|txt|wasm|webmanifest)$/

/** Compresses all that gains by it; what is compressed already, and newer, stays. Returns how many bytes of each file are sent. @param {string} folder */
export async function compressAll(folder) {
  const names = (await readdir(folder, { recursive: true })).filter((name) => !name.endsWith('.br'))
  const sizes = await Promise.all(
    names.map(async (name) => {
      const path = join(folder, name)
      const file = await stat(path)
      if (!file.isFile()) return []
      return [{ name, bytes: file.size, sent: TEXTS.test(name) ? await compress(path, file) : file.size }]
    }),
  )
  return sizes.flat()
}

/** @param {string} path @param {import('node:fs').Stats} file */
async function compress(path, file) {
  const ready = await stat(`${path}.br`).catch(() => undefined)
  if (ready && file.mtimeMs <= ready.mtimeMs) return ready.size
  const bytes = await readFile(path)
  const params = { [constants.BROTLI_PARAM_LGWIN]: constants.BROTLI_MAX_WINDOW_BITS, [constants.BROTLI_PARAM_SIZE_HINT]: bytes.length }
  const small = await promisify(brotliCompress)(bytes, { params })
  await writeFile(`${path}.br`, small)
  return small.length
}

if (argv[1] === fileURLToPath(import.meta.url)) {
  const kB = (/** @type {number} */ bytes) => `${Math.ceil(bytes / 1000)} kB`
  for (const { name, bytes, sent } of await compressAll(argv[2])) if (sent < bytes) console.log(`  ${name}: ${kB(bytes)}, ${kB(sent)} with brotli`)
}
