// Serves the page on this machine only:  node scripts/serve.mjs [--dev] [PORT]
//
// What the build delivers (scripts/bundle.mjs), or with --dev www/ as it is. --dev also takes the service worker back, which
// answers with the files of the last build: an edit shows on the next reload.
// PORT (or $PORT) is used as given; without it, 8080 or the next free one. A browser asks every time whether a file is
// another one, so that a reload shows the last build. Files go out with brotli or gzip, as from the servers of the world: what
// the build has compressed beside the file (scripts/compress.mjs), or else what is compressed here when it is first asked for.

import { readFile, stat } from 'node:fs/promises'
import { createServer } from 'node:http'
import { extname, join, sep } from 'node:path'
import { argv, env } from 'node:process'
import { fileURLToPath } from 'node:url'
import { promisify } from 'node:util'
import { brotliCompress, constants, gzip } from 'node:zlib'

const WWW = fileURLToPath(new URL('../www', import.meta.url))
const DELIVERED = fileURLToPath(new URL('../target/delivered', import.meta.url))

/** @type {Record<string, string>} */
const TYPES = {
  '.css': 'text/css; charset=utf-8',
  '.html': 'text/html; charset=utf-8',
  '.ico': 'image/x-icon',
  '.js': 'text/javascript; charset=utf-8',
  '.json': 'application/json',
  '.mjs': 'text/javascript; charset=utf-8',
  '.png': 'image/png',
  '.svg': 'image/svg+xml',
  '.txt': 'text/plain; charset=utf-8',
  '.wasm': 'application/wasm',
  '.webmanifest': 'application/manifest+json',
  '.webp': 'image/webp',
}

/** Brotli's last two steps take a second a megabyte for another tenth: they are for small files, and for the build. */
const SMALL_BYTES = 100_000

/**
 * The best first.
 * @type {Record<string, (bytes: Buffer) => Promise<Buffer>>}
 */
const ENCODERS = {
  br: (bytes) => promisify(brotliCompress)(bytes, { params: { [constants.BROTLI_PARAM_QUALITY]: bytes.length < SMALL_BYTES ? 11 : 9 } }),
  gzip: (bytes) => promisify(gzip)(bytes, { level: 9 }),
}

/** In place of the page's service worker: forgets what that kept, and unregisters. The page that it controlled loads again without it. */
const NO_SERVICE_WORKER = `
self.addEventListener('install', () => self.skipWaiting())
self.addEventListener('activate', (event) => event.waitUntil(leave()))
async function leave() {
  for (const name of await caches.keys()) await caches.delete(name)
  await self.registration.unregister()
  for (const page of await self.clients.matchAll({ type: 'window' })) page.navigate(page.url)
}
`

/**
 * Starts the server; port 0 takes any free one. A file is looked for in the folders in their order.
 * @param {number} port
 * @param {string[]} [folders]
 * @param {{ isDev?: boolean }} [options] `isDev`: without the service worker
 * @returns {Promise<{ origin: string, close: () => Promise<void> }>}
 */
export async function serve(port, folders = [WWW], { isDev = false } = {}) {
  const server = createServer((request, response) => {
    const isServiceWorker = /^\/sw\.js($|[?#])/.test(request.url ?? '')
    return isDev && isServiceWorker ? withoutServiceWorker(response) : answer(folders, request, response)
  })
  // A connection stays open until the page leaves; a time limit would be told with each of the page's many small files.
  server.keepAliveTimeout = 0
  await new Promise((resolve, reject) => {
    server.once('error', reject).listen(port, '127.0.0.1', () => resolve(undefined))
  })
  const address = /** @type {import('node:net').AddressInfo} */ (server.address())
  return {
    origin: `http://127.0.0.1:${address.port}`,
    close: () =>
      new Promise((resolve) => {
        server.close(() => resolve())
        server.closeAllConnections?.()
      }),
  }
}

/**
 * @param {string[]} folders
 * @param {import('node:http').IncomingMessage} request
 * @param {import('node:http').ServerResponse} response
 */
async function answer(folders, request, response) {
  if (request.method !== 'GET' && request.method !== 'HEAD') return refuse(response, 405)
  const paths = folders.map((folder) => fileOf(folder, request.url ?? '/')).filter((path) => path !== undefined)
  if (paths.length === 0) return refuse(response, 400)
  const files = await Promise.all(paths.map((path) => stat(path).catch(() => undefined)))
  const index = files.findIndex((file) => file?.isFile())
  const [path, file] = [paths[index], files[index]]
  if (!file) return refuse(response, 404)

  const version = `"${file.size}-${file.mtimeMs}"`
  const headers = { 'Cache-Control': 'no-cache', ETag: version, Vary: 'Accept-Encoding' }
  if (request.headers['if-none-match'] === version) return response.writeHead(304, headers).end()
  const accepted = String(request.headers['accept-encoding'])
  const encoding = Object.keys(ENCODERS).find((name) => new RegExp(`\\b${name}\\b`).test(accepted))
  const body = await (encoding ? compressed(path, version, encoding) : readFile(path)).catch(() => undefined)
  if (!body) return response.destroy()
  response.writeHead(200, {
    ...headers,
    'Content-Type': TYPES[extname(path)] ?? 'text/plain; charset=utf-8',
    'Content-Length': body.length,
    ...(encoding && { 'Content-Encoding': encoding }),
  })
  response.end(request.method === 'HEAD' ? undefined : body)
}

/** @param {import('node:http').ServerResponse} response */
function withoutServiceWorker(response) {
  response.writeHead(200, { 'Cache-Control': 'no-store', 'Content-Type': TYPES['.js'] }).end(NO_SERVICE_WORKER)
}

/** What was compressed, by path and encoding. @type {Map<string, {version: string, body: Promise<Buffer>}>} */
const kept = new Map()

/** @param {string} path @param {string} version @param {string} encoding */
function compressed(path, version, encoding) {
  const key = `${encoding} ${path}`
  const former = kept.get(key)
  if (former?.version === version) return former.body
  const body = compressedByBuild(path, encoding).then((ready) => ready ?? readFile(path).then(ENCODERS[encoding]))
  kept.set(key, { version, body })
  return body
}

/** What the build has compressed, unless the file is another one since. @param {string} path @param {string} encoding */
async function compressedByBuild(path, encoding) {
  try {
    const [file, ready] = await Promise.all([stat(path), stat(`${path}.${encoding}`)])
    return file.mtimeMs <= ready.mtimeMs ? await readFile(`${path}.${encoding}`) : undefined
  } catch {
    return undefined
  }
}

/**
 * File of a request, or nothing where its path is malformed or leads out of the folder.
 * @param {string} folder
 * @param {string} url
 */
function fileOf(folder, url) {
  let path
  try {
    path = decodeURIComponent(url.replace(/[?#].*/s, ''))
  } catch {
    return undefined
  }
  if (path.includes('\0')) return undefined
  const file = join(folder, path.endsWith('/') ? `${path}index.html` : path)
  return file.startsWith(folder + sep) ? file : undefined
}

/**
 * @param {import('node:http').ServerResponse} response
 * @param {number} status
 */
function refuse(response, status) {
  response.writeHead(status, { 'Content-Type': 'text/plain' }).end(`${status}\n`)
}

/** @param {number} port @param {{ isDev: boolean }} options */
async function serveFrom(port, options) {
  for (;;) {
    try {
      return await serve(port, [options.isDev ? WWW : DELIVERED], options)
    } catch (error) {
      if (/** @type {NodeJS.ErrnoException} */ (error).code !== 'EADDRINUSE') throw error
      port += 1
    }
  }
}

if (argv[1] === fileURLToPath(import.meta.url)) {
  const isDev = argv.includes('--dev')
  const wanted = argv.slice(2).find((argument) => argument !== '--dev') ?? env.PORT
  try {
    const { origin } = await (wanted ? serve(Number(wanted), [isDev ? WWW : DELIVERED], { isDev }) : serveFrom(8080, { isDev }))
    console.log(`The page is at ${origin}/  (Ctrl-C ends the server)`)
  } catch (error) {
    console.error(`cannot serve: ${/** @type {Error} */ (error).message}`)
    process.exitCode = 1
  }
}
