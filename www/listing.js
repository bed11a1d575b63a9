// The text of a program, line by line, of which only what is in sight is in the page.

import { make } from './dom.js'

/** @import { Lines } from "./lines.js" */

const ROW = 18
/** Browsers cut off elements that are much higher; longer programs scroll faster than they are read. */
const HIGHEST = 8_000_000
const MARGIN = 6

/**
 * @param {HTMLElement} root
 * @param {object} hear
 * @param {(line: number) => void} hear.chosen  a line was clicked on
 * @param {(line: number | null) => void} hear.pointed  the pointer is on a line, or on none
 */
export function mountListing(root, { chosen, pointed }) {
  const whole = make('div', { className: 'whole' })
  whole.setAttribute('role', 'presentation')
  root.append(whole)
  /** @type {Lines | undefined} */
  let lines
  let count = 0
  let selected = 0
  let hovered = 0
  let frame = 0
  /** The rows in the page, by line. @type {Map<number, HTMLElement>} */
  const rows = new Map()

  const height = () => Math.min(count * ROW, HIGHEST)
  /** How many pixels of all lines a pixel of the scroll bar stands for. */
  const stretch = () => {
    const room = height() - root.clientHeight
    return room > 0 ? (count * ROW - root.clientHeight) / room : 1
  }

  function redraw() {
    frame ||= requestAnimationFrame(() => {
      frame = 0
      const top = root.scrollTop * stretch()
      const first = Math.max(Math.floor(top / ROW) - MARGIN, 0)
      const last = Math.min(Math.ceil((top + root.clientHeight) / ROW) + MARGIN, count)
      for (const [line, element] of rows) {
        if (first < line && line <= last) continue
        element.remove()
        rows.delete(line)
      }
      for (let line = first + 1, before = null; line <= last; line += 1) before = draw(line, root.scrollTop + (line - 1) * ROW - top, before)
      if (first < selected && selected <= last) root.setAttribute('aria-activedescendant', `program-line-${selected}`)
      else root.removeAttribute('aria-activedescendant')
    })
  }

  /** The text of a line; nothing until it is read, which draws it. @param {number} line */
  function textOf(line) {
    const own = lines
    const text = own?.known(line)
    if (text === undefined) own?.at(line).then(() => own === lines && own.known(line) !== undefined && redraw())
    return text ?? ''
  }

  /** Draws a line in the row that it has: a row that is replaced while it is pressed gets no click. @param {number} line @param {number} top @param {HTMLElement | null} before  the row above it */
  function draw(line, top, before) {
    const element = rows.get(line) ?? row(line, before)
    element.setAttribute('aria-selected', String(line === selected))
    element.style.top = `${top}px`
    const text = textOf(line)
    const written = /** @type {Text} */ (element.lastChild)
    if (written.data !== text) written.data = text
    return element
  }

  /** @param {number} line @param {HTMLElement | null} before */
  function row(line, before) {
    const number = make('span', { className: 'number' }, String(line))
    const element = make('div', { id: `program-line-${line}`, className: line === hovered ? 'pointed' : '' }, number, document.createTextNode(''))
    element.setAttribute('role', 'option')
    element.setAttribute('aria-setsize', String(count))
    element.setAttribute('aria-posinset', String(line))
    element.dataset.line = String(line)
    if (before) before.after(element)
    else whole.prepend(element)
    rows.set(line, element)
    return element
  }

  /** @param {Event} event */
  const lineAt = ({ target }) => Number(/** @type {HTMLElement} */ (target).closest('[data-line]')?.getAttribute('data-line')) || null

  root.addEventListener('scroll', redraw, { passive: true })
  root.addEventListener('click', (event) => {
    const line = lineAt(event)
    if (line) select(line)
  })
  root.addEventListener('pointermove', (event) => {
    const line = lineAt(event)
    if (line === hovered) return
    point(line ?? 0)
    pointed(line)
  })
  root.addEventListener('pointerleave', () => {
    point(0)
    pointed(null)
  })
  root.addEventListener('keydown', (event) => {
    const page = Math.max(Math.floor(root.clientHeight / ROW) - 1, 1)
    /** @type {Record<string, number>} */
    const to = { ArrowUp: selected - 1, ArrowDown: selected + 1, PageUp: selected - page, PageDown: selected + page, Home: 1, End: count }
    if (!(event.key in to) || count === 0 || event.ctrlKey || event.metaKey || event.altKey) return
    event.preventDefault()
    select(Math.min(Math.max(to[event.key], 1), count))
    show(selected)
  })
  let wasHidden = true
  new ResizeObserver(() => {
    const isHidden = root.clientHeight === 0
    // What was chosen while it was hidden is to be seen first.
    if (wasHidden && !isHidden && selected > 0) show(selected)
    else redraw()
    wasHidden = isHidden
  }).observe(root)

  /** @param {number} line */
  function select(line) {
    selected = line
    redraw()
    chosen(line)
  }

  /** Scrolls to a line, if it is not in sight. @param {number} line */
  function show(line) {
    const top = root.scrollTop * stretch()
    const at = (line - 1) * ROW
    if (at < top || top + root.clientHeight < at + ROW) root.scrollTop = Math.max(at - root.clientHeight / 2, 0) / stretch()
    redraw()
  }

  /** @param {number} line */
  function point(line) {
    if (line === hovered) return
    whole.querySelector('.pointed')?.classList.remove('pointed')
    hovered = line
    if (line > 0) whole.querySelector(`[data-line="${line}"]`)?.classList.add('pointed')
  }

  return {
    /** Shows the lines of a program. @param {Lines} now */
    async fill(now) {
      lines = now
      selected = hovered = count = 0
      rows.clear()
      whole.replaceChildren()
      root.scrollTop = 0
      const all = await now.count()
      if (lines !== now) return
      count = all
      whole.style.height = `${height()}px`
      if (selected > 0) show(selected)
      redraw()
    },
    /** Selects a line and brings it in sight. @param {number} line */
    choose(line) {
      selected = line
      show(line)
    },
    point,
  }
}
