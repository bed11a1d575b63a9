// What stands around a chart: the names of its curves, which show and hide them, tools and operations above it, and the whole
// in small below it, with the part that is in sight.

import { make } from './dom.js'
import { sheetOf } from './drawing.js'
import { operationTitle, toolTitle } from './operations.js'
import { say } from './texts.js'

/** @import { Chart, Filled } from "./plot.js" */
/** @import { Operation } from "./types.js" */

/** So near to an end of the window one has hold of that end, pixels. */
const END_PX = 7
/** Narrower parts have no name. */
const NAMED_PX = 26
/** Narrower parts are not shown one by one. */
const LEAST_PX = 2

/**
 * @param {HTMLElement} plot
 * @param {Chart} chart
 * @param {object} hear
 * @param {() => boolean} hear.isShown
 * @param {() => Operation[]} hear.operations
 * @param {() => void} hear.changed  another curve is shown
 * @param {() => void} hear.moved  another part is in sight
 */
export function surround(plot, chart, { isShown, operations, changed, moved }) {
  const legend = make('div', { className: 'curves' })
  legend.setAttribute('role', 'group')
  legend.setAttribute('aria-label', say.charts.curves)
  const bands = make('div', { className: 'bands' })
  bands.setAttribute('aria-hidden', 'true')
  const frame = make('span', { className: 'window' })
  const canvas = make('canvas', {})
  const whole = make('div', { className: 'overview', title: say.charts.overview }, canvas, frame)
  whole.setAttribute('aria-hidden', 'true')
  plot.before(legend, bands)
  plot.after(whole)

  /** The curves that are left out, by their names. @type {Set<string>} */
  const left = new Set()
  let listed = ''
  const names = () => [say.charts.programmed, ...chart.labels()]

  /** Leaves out of a chart what is left out of this one. @param {Filled} other */
  function hideIn(other) {
    for (const [index, name] of names().entries()) other.setHidden(index === 0 ? undefined : index - 1, left.has(name))
  }

  function fillLegend() {
    const all = names()
    if (all.join('\n') === listed) return
    listed = all.join('\n')
    legend.replaceChildren(
      ...all.map((name, index) => {
        const button = make('button', { type: 'button' }, make('span', { className: `swatch ${index === 0 ? 'asked' : `curve-${index - 1}`}` }), name)
        button.setAttribute('aria-pressed', String(!left.has(name)))
        button.addEventListener('click', () => {
          if (!left.delete(name)) left.add(name)
          button.setAttribute('aria-pressed', String(!left.has(name)))
          hideIn(chart)
          changed()
        })
        return button
      }),
    )
  }

  /** Tools and operations over the part in sight. */
  function fillBands() {
    const all = operations()
    bands.hidden = all.length < 2
    if (bands.hidden) return
    const [edge] = chart.area()
    const columns = chart.columns(Float64Array.from(all.flatMap(({ distance_mm: ends }) => ends)))
    const tools = [...new Set(all.map(({ tool }) => tool))]
    const parts = []
    let last = -Infinity
    for (const [index, operation] of all.entries()) {
      const [from, to] = columns.subarray(2 * index, 2 * index + 2)
      if (to - Math.max(from, last) < LEAST_PX) continue
      last = to
      const part = make('span', { title: `${toolTitle(operation)} ${operationTitle(operation)}` }, to - from < NAMED_PX ? '' : nameOf(operation))
      part.dataset.part = String(tools.indexOf(operation.tool) % 2)
      Object.assign(part.style, { left: `${from - edge}px`, width: `${to - from - 1}px` })
      parts.push(part)
    }
    bands.replaceChildren(...parts)
  }

  function placeWindow() {
    const [from, to] = chart.part()
    frame.style.left = `${100 * from}%`
    frame.style.width = `${100 * (to - from)}%`
  }

  const sheet = sheetOf(canvas, () => {
    if (!isShown()) return
    chart.drawOverview(canvas, sheet.width, sheet.height, sheet.ratio())
    placeWindow()
  })

  whole.addEventListener('pointerdown', (start) => {
    if (!isShown() || start.button !== 0) return
    const { left: edge, width } = whole.getBoundingClientRect()
    const at = (/** @type {PointerEvent} */ event) => (event.clientX - edge) / width
    const begun = at(start)
    let [from, to] = chart.part()
    const near = END_PX / width
    const holds = { from: Math.abs(begun - from) < near, to: Math.abs(begun - to) < near }
    if (!holds.from && !holds.to && (begun < from || to < begun)) {
      const half = (to - from) / 2
      ;[from, to] = [begun - half, begun + half]
    }
    whole.setPointerCapture(start.pointerId)
    const show = (/** @type {PointerEvent} */ event) => {
      const by = at(event) - begun
      const ends = [holds.to ? from : from + by, holds.from ? to : to + by]
      chart.showPart(Math.min(...ends), Math.max(...ends))
      moved()
    }
    show(start)
    const end = () => {
      whole.removeEventListener('pointermove', show)
      whole.removeEventListener('pointerup', end)
      whole.removeEventListener('pointercancel', end)
    }
    whole.addEventListener('pointermove', show)
    whole.addEventListener('pointerup', end)
    whole.addEventListener('pointercancel', end)
  })

  return {
    hideIn,
    /** Another program or curve is there. */
    filled() {
      fillLegend()
      hideIn(chart)
      sheet.redraw()
    },
    /** Draws the whole in small again, in other colours. */
    redraw: sheet.redraw,
    /** The chart was drawn. */
    drawn() {
      const [from, to] = chart.area()
      for (const element of [bands, whole]) {
        element.style.marginLeft = `${from}px`
        element.style.width = `${to - from}px`
      }
      fillBands()
      placeWindow()
    },
  }
}

/** What stands on a band. @param {Operation} operation */
const nameOf = (operation) => [operation.tool === null ? '' : toolTitle(operation), operation.name ?? ''].join(' ').trim()
