// The two WebAssembly modules, each fetched and compiled once for all that is on a page, when it is first asked for: the small
// one of a first visit, and the whole, which is quicker.

/** A module, and which. @typedef {{module: WebAssembly.Module, isWhole: boolean}} Compiled */

const first = compiledOnce(new URL('./pkg/truefeed_bg.wasm', import.meta.url))
const whole = compiledOnce(new URL('./pkg/truefeed_whole_bg.wasm', import.meta.url))

/** @returns {Promise<Compiled>} */
export const firstModule = async () => ({ module: await first(), isWhole: false })

/** @returns {Promise<Compiled>} */
export const wholeModule = async () => ({ module: await whole(), isWhole: true })

/** @param {URL} address @returns {() => Promise<WebAssembly.Module>} */
function compiledOnce(address) {
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
