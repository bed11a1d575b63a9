// Compresses the files of a folder as well as brotli can, beside them:  node scripts/compress.mjs FOLDER
//
// It takes seconds a file, so that the build does it once and a server sends FILE.br in the place of FILE.

import { readFileSync, readdirSync, writeFileSync } from 'node:fs'
import { join } from 'node:path'
import { argv } from 'node:process'
import { brotliCompressSync, constants } from 'node:zlib'

const [, , folder] = argv
for (const name of readdirSync(folder)) {
  if (!/\.(js|wasm|txt)$/.test(name)) continue
  const path = join(folder, name)
  const bytes = readFileSync(path)
  const params = { [constants.BROTLI_PARAM_LGWIN]: constants.BROTLI_MAX_WINDOW_BITS, [constants.BROTLI_PARAM_SIZE_HINT]: bytes.length }
  const small = brotliCompressSync(bytes, { params })
  writeFileSync(`${path}.br`, small)
  console.log(`  ${name}: ${Math.ceil(bytes.length / 1000)} kB, ${Math.ceil(small.length / 1000)} kB with brotli`)
}
