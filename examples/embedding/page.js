// Sets the second component by its properties, and says what both of them tell.

const second = document.querySelector('#second')
const said = document.querySelector('#said')

second.machine = 'Older or heavy machine'
second.tolerances = [0.05, 0.1]

document.querySelector('#write').addEventListener('click', () => {
  second.name = 'zigzag.nc'
  const rows = Array.from({ length: 200 }, (_, row) => `G1 X${row % 2 ? 0 : 80} Y${row * 0.5}`)
  second.program = ['G21 G90 G94', 'G0 X0 Y0 Z5', 'G1 Z-1 F600', 'F3000', ...rows, 'G0 Z50', 'M30'].join('\n')
})

for (const element of document.querySelectorAll('truefeed-quote')) {
  element.addEventListener('quote', ({ detail: quote }) => {
    const times = quote.runs.map((run) => `${run.cycle_time_s.toFixed(1)} s at ${run.tolerance_mm} mm`)
    said.textContent = `${quote.program}: ${times.join(', ')}`
  })
  element.addEventListener('error', ({ detail }) => {
    said.textContent = `${detail.kind}: ${detail.message}`
  })
}
