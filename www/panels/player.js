// Plays a program: the tool runs along the path as the machine would, or faster, with a clock.

import { between } from '../pkg/truefeed_whole.js'
import { find } from '../dom.js'
import { clock } from '../format.js'
import { say } from '../texts_later.js'

/** @import { Columns } from "../types.js" */

/** The whole program takes so long where that is chosen, s. */
const WHOLE_S = 30
/** The slider has so many steps. */
const STEPS = 1000

/**
 * @param {HTMLElement} root
 * @param {object} hear
 * @param {(distance: number) => void} hear.at  the tool is at a distance, mm
 * @param {() => void} hear.ended  all has been run
 */
export function mountPlayer(root, { at, ended }) {
  const button = find(root, '.play')
  const slider = /** @type {HTMLInputElement} */ (find(root, 'input'))
  const pace = /** @type {HTMLSelectElement} */ (find(root, 'select'))
  const [now, whole] = [find(root, '.now'), find(root, '.whole')]
  slider.max = String(STEPS)
  /** @type {Columns | undefined} */
  let columns
  let time = 0
  let frame = 0
  let last = 0

  const end = () => columns?.time.at(-1) ?? 0
  const isPlaying = () => frame !== 0

  function tell() {
    slider.value = String(end() > 0 ? (STEPS * time) / end() : 0)
    slider.setAttribute('aria-valuetext', say.path.clockOf(clock(time), clock(end())))
    now.textContent = clock(time)
    whole.textContent = ` / ${clock(end())}`
  }

  /** Puts the tool where it is at a time, s. @param {number} to */
  function go(to) {
    if (!columns) return
    time = Math.min(Math.max(to, 0), end())
    tell()
    if (time >= end()) {
      stop()
      ended()
    } else at(between(columns.time, columns.distance, time))
  }

  /** @param {number} tick */
  function step(tick) {
    const passed = Math.min(tick - last, 100) / 1000
    last = tick
    frame = requestAnimationFrame(step)
    go(time + passed * (Number(pace.value) || end() / WHOLE_S))
  }

  function stop() {
    cancelAnimationFrame(frame)
    frame = 0
    show()
  }

  function toggle() {
    if (isPlaying()) return stop()
    if (end() === 0) return
    if (time >= end()) time = 0
    last = performance.now()
    frame = requestAnimationFrame(step)
    show()
  }

  function show() {
    button.textContent = isPlaying() ? '❚❚' : '▶'
    button.setAttribute('aria-label', isPlaying() ? say.path.pause : say.path.play)
    button.title = `${isPlaying() ? say.path.pause : say.path.play} (${say.path.space})`
  }

  button.addEventListener('click', toggle)
  slider.addEventListener('input', () => go((Number(slider.value) / STEPS) * end()))
  show()

  return {
    toggle,
    isPlaying,
    stop,
    /** Begins anew with a run, or with none. @param {Columns | undefined} run */
    fill(run) {
      if (run === columns) return
      stop()
      columns = run
      time = 0
      root.hidden = end() === 0
      tell()
    },
    /** Goes on from a distance, mm. @param {number} distance */
    from(distance) {
      if (!columns) return
      time = between(columns.distance, columns.time, distance)
      tell()
    },
  }
}
