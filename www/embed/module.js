// The WebAssembly module of a first visit, fetched and compiled once for all that is on a page.

export const compiledModule = compiledOnce(new URL('../pkg/truefeed_bg.wasm', import.meta.url))

/** What gets the module of an address, when it is first asked for. @param {URL} address @returns {() => Promise<WebAssembly.Module>} */
export function compiledOnce(address) {
  /** @type {Promise<WebAssembly.Module> | undefined} */
  let compiled
  return () => {
    compiled ??= compile(address).catch((error) => {
      // The next one tries again.
      compiled = undefined
      throw error
    })
    return compiled
  }
}

/** @param {URL} address */
async function compile(address) {
  const response = await fetch(address)
  if (!response.ok) throw new Error(`the module cannot be fetched: ${response.status} ${response.statusText}`)
  return WebAssembly.compile(await response.arrayBuffer())
}
