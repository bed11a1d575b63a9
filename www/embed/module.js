// The WebAssembly module, fetched and compiled once for all that is on a page.

/** @type {Promise<WebAssembly.Module> | undefined} */
let compiled

/** @returns {Promise<WebAssembly.Module>} */
export function compiledModule() {
  compiled ??= compile().catch((error) => {
    // The next one tries again.
    compiled = undefined
    throw error
  })
  return compiled
}

async function compile() {
  const response = await fetch(new URL('../pkg/truefeed_bg.wasm', import.meta.url))
  if (!response.ok) throw new Error(`the module cannot be fetched: ${response.status} ${response.statusText}`)
  return WebAssembly.compile(await response.arrayBuffer())
}
