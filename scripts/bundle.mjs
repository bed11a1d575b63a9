// Bundles www/ for delivery:  node scripts/bundle.mjs [OUT]. Needs: scripts/build. It bundles a quick build only into OUT, for tests.
//
// The same page in fewer and smaller files, at the same addresses: scripts and styles without comments, modules that are loaded
// together in one file, and beside each text its form with brotli. Development and tests need none of it: www/ works as it is.

import { createHash } from 'node:crypto'
import { existsSync } from 'node:fs'
import { cp, mkdir, readFile, readdir, rm, writeFile } from 'node:fs/promises'
import { join, relative } from 'node:path'
import { argv } from 'node:process'
import { fileURLToPath } from 'node:url'
import { transform } from 'lightningcss'
import { rolldown } from 'rolldown'
import { minify } from 'vite'
import { compressAll } from './compress.mjs'

const ROOT = fileURLToPath(new URL('..', import.meta.url))
const WWW = join(ROOT, 'www')
const OUT = argv[2] ?? join(ROOT, 'target/delivered')

/** What other files name: the page's own, the worker's, and what other pages embed. */
const ENTRIES = ['main', 'offline', 'worker', 'embed/quote', 'embed/frame']
/** What stays as it is. */
const COPIED = /^(index|embed)\.html$|\.(svg|webmanifest)$|^samples\/|^pkg\/.*(\.wasm|notices\.txt)(\.br)?$/
/** What the page does without when there is no network: what it is kept by, and what is sent in the place of a file. */
const NOT_KEPT = /^sw\.js$|^pkg\/files\.js$|\.br$/

const files = async (/** @type {string} */ folder) =>
  (await readdir(folder, { recursive: true, withFileTypes: true })).filter((entry) => entry.isFile()).map((entry) => relative(folder, join(entry.parentPath, entry.name)).replaceAll('\\', '/'))

if (!argv[2] && existsSync(join(WWW, 'pkg/quick-build'))) throw new Error('www/pkg is a quick build, for tests only; run scripts/build')

await rm(OUT, { recursive: true, force: true })
await mkdir(OUT, { recursive: true })

const bundle = await rolldown({
  input: Object.fromEntries(ENTRIES.map((name) => [name, join(WWW, `${name}.js`)])),
  // A module is for what it does when it is loaded, too.
  treeshake: { moduleSideEffects: true },
})
await bundle.write({
  dir: OUT,
  format: 'esm',
  // Addresses beside a module (`import.meta.url`) are all of modules in www/ itself, and so are these.
  entryFileNames: '[name].js',
  chunkFileNames: 'part-[hash].js',
  minify: true,
})
await bundle.close()

for (const name of await files(WWW)) {
  const [from, to] = [join(WWW, name), join(OUT, name)]
  // With its time, by which a server knows what the build has compressed.
  if (COPIED.test(name)) await cp(from, to, { preserveTimestamps: true })
  else if (/\.css$/.test(name)) await put(to, transform({ filename: name, code: await readFile(from), minify: true }).code)
}
await put(join(OUT, 'sw.js'), (await minify('sw.js', await readFile(join(WWW, 'sw.js'), 'utf8'))).code)

const kept = (await files(OUT)).filter((name) => !NOT_KEPT.test(name)).sort()
const hash = createHash('sha256')
for (const name of kept) hash.update(name).update(await readFile(join(OUT, name)))
await put(join(OUT, 'pkg/files.js'), `self.truefeedFiles=${JSON.stringify({ version: hash.digest('hex').slice(0, 16), files: kept })}\n`)

const sizes = await compressAll(OUT)
const sum = sizes.reduce((total, { sent }) => total + sent, 0)
console.log(`${kept.length} files in ${relative(ROOT, OUT)}, ${Math.ceil(sum / 1000)} kB as they are sent`)

/** @param {string} path @param {string | Uint8Array} content */
async function put(path, content) {
  await mkdir(join(path, '..'), { recursive: true })
  await writeFile(path, content)
}
