// Keeps the page's own files, so that it works without a network. One cache a version; nothing else is ever kept or asked for.
//
// A new version is fetched beside the one in use, and takes its place when the page is loaded again and no other tab
// still has the old one: files of two versions never meet.

/** The scope of a service worker, which the library of pages does not know. @type {any} */
const worker = self

worker.importScripts('pkg/files.js')
/** @type {{version: string, files: string[]}} */
const { version, files } = worker.truefeedFiles
const PREFIX = 'truefeed-'
const NAME = PREFIX + version
const PAGE = new URL('index.html', worker.registration.scope).href

worker.addEventListener('install', (/** @type {any} */ event) => event.waitUntil(fetchAll()))
worker.addEventListener('activate', (/** @type {any} */ event) => event.waitUntil(dropOthers()))
worker.addEventListener('message', (/** @type {any} */ event) => event.waitUntil(takeOver(event.data)))
worker.addEventListener('fetch', (/** @type {any} */ event) => {
  const { request } = event
  const isOwn = request.url.startsWith(worker.registration.scope)
  if (isOwn && request.method === 'GET') event.respondWith(kept(request))
})

async function fetchAll() {
  const cache = await caches.open(NAME)
  // The browser's own cache is asked, but made to check that it is up to date. One file after the other, as all at once
  // would take the processors from a page in use.
  for (const file of files) await cache.add(new Request(file, { cache: 'no-cache' }))
}

async function dropOthers() {
  const names = await caches.keys()
  await Promise.all(names.filter((name) => name.startsWith(PREFIX) && name !== NAME).map((name) => caches.delete(name)))
}

/** A page that has just been loaded asks for the version that waits. @param {unknown} wish */
async function takeOver(wish) {
  const pages = await worker.clients.matchAll({ includeUncontrolled: true })
  if (wish === 'update' && pages.length === 1) await worker.skipWaiting()
}

/** @param {Request} request */
async function kept(request) {
  const { origin, pathname } = new URL(request.url)
  const address = origin + pathname
  const cache = await caches.open(NAME)
  return (await cache.match(address === worker.registration.scope ? PAGE : address)) ?? fetch(request)
}
