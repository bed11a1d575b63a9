// Makes the page work without a network after the first load, and takes an update when it is loaded again.

import { say } from './texts.js'

const line = document.getElementById('offline')

/** Settles a moment after the page has loaded, when it asks for no file any more. */
const settled = new Promise((done) => {
  const wait = () => setTimeout(done, 1500)
  if (document.readyState === 'complete') wait()
  else addEventListener('load', wait, { once: true })
})

/** @param {ServiceWorkerContainer} workers */
async function keep(workers) {
  // What it fetches to keep does not stand in the way of what is looked at first, and Chromium forgets the change to
  // a new version where a file is asked for at the same moment.
  await settled
  const registration = await workers.register('sw.js', { updateViaCache: 'none' })
  if (registration.waiting) {
    // The page begins again with what it had, which is kept.
    workers.addEventListener('controllerchange', () => location.reload(), { once: true })
    registration.waiting.postMessage('update')
  }
  await workers.ready
  if (line) line.textContent = say.page.offline
}

// Where there is no such worker, or it may not run, the page works all the same while there is a network.
if ('serviceWorker' in navigator) keep(navigator.serviceWorker).catch(() => {})

export {}
