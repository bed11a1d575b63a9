// Speaks with the frame. Each message has an id, and the answer to it has the same.

const truefeed = new URLSearchParams(location.search).get('truefeed')
const frame = document.querySelector('iframe')
const said = document.querySelector('#said')
const waiting = new Map()
let lastId = 0

/** Sends a message; resolves with the answer to it. */
function ask(type, content = {}) {
  const id = ++lastId
  frame.contentWindow.postMessage({ truefeed: 1, id, type, ...content }, truefeed)
  return new Promise((resolve, reject) => waiting.set(id, { resolve, reject }))
}

window.addEventListener('message', ({ origin, source, data }) => {
  if (origin !== truefeed || source !== frame.contentWindow || data?.truefeed !== 1) return
  const { id, type } = data
  if (type === 'ready' && id === null) begin()
  else if (type === 'resize') frame.style.height = `${data.height}px`
  else if (type === 'progress') said.textContent = `${Math.round(100 * data.part)} %`
  else if (waiting.has(id)) {
    const { resolve, reject } = waiting.get(id)
    waiting.delete(id)
    if (type === 'error') reject(data.error)
    else resolve(data)
  }
})

async function begin() {
  await ask('set-theme', { theme: { '--truefeed-accent': '#b3541e', '--truefeed-radius': '14px' } })
  await ask('set-machine', { machine: { preset: 'Vertical machining centre, mid-range', 'rates.hourly': 85 } })
  await ask('set-tolerances', { tolerances: [0.01, 0.05] })
  said.textContent = 'Ready.'
}

document.querySelector('button').addEventListener('click', async () => {
  try {
    await ask('load-program', { program: document.querySelector('textarea').value, name: 'order-4711.nc' })
    const { quote } = await ask('get-quote')
    const [first] = quote.runs
    said.textContent = `${first.cycle_time_s.toFixed(1)} s a part, ${first.price.toFixed(2)} at 85 an hour`
  } catch (error) {
    said.textContent = `${error.kind}: ${error.message}`
  }
})

// Only now, so that the first message of the frame is heard.
frame.src = `${truefeed}/embed.html?origin=${encodeURIComponent(location.origin)}`
