// A worker under the policy of the page. A worker from an address has the policy that its server sends, which may be none;
// one from a blob has that of the page that made it.

const SOURCE = `import ${JSON.stringify(new URL('worker.js', import.meta.url).href)}`

/** @type {string | undefined} */
let address

export function confinedWorker() {
  address ??= URL.createObjectURL(new Blob([SOURCE], { type: 'text/javascript' }))
  return new Worker(address, { type: 'module' })
}
