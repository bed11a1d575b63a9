// Makes the page work without a network after the first load, and takes an update when it is loaded again.

const line = document.getElementById('offline')

/** @param {ServiceWorkerContainer} workers */
async function keep(workers) {
  const registration = await workers.register('sw.js', { updateViaCache: 'none' })
  if (registration.waiting) {
    // Nothing has been entered yet, so that the page can begin again.
    workers.addEventListener('controllerchange', () => location.reload(), { once: true })
    registration.waiting.postMessage('update')
  }
  await workers.ready
  if (line) line.textContent = 'It works without a network.'
}

// Where there is no such worker, or it may not run, the page works all the same while there is a network.
if ('serviceWorker' in navigator) keep(navigator.serviceWorker).catch(() => {})

export {}
