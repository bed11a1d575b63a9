// What opens below the picture, one at a time, and goes away again: by its button, by × and by Escape.

import { find } from '../dom.js'

/** @param {HTMLElement} strip  of buttons, each with the ids of what it opens @param {HTMLElement} place @param {(ids: string[]) => void} shown  others are open */
export function mount(strip, place, shown) {
  const buttons = [...strip.querySelectorAll('button')]
  const idsOf = (/** @type {HTMLElement} */ button) => (button.getAttribute('aria-controls') ?? '').split(' ')
  const isOpen = (/** @type {HTMLElement} */ button) => button.getAttribute('aria-expanded') === 'true'

  /** What a panel that was revealed waits for. @type {(() => boolean) | undefined} */
  let awaited
  /** What comes in sight then. */
  let target = strip
  for (const kind of ['wheel', 'pointerdown', 'keydown']) window.addEventListener(kind, () => (awaited = undefined), { passive: true })

  /** Opens what a button stands for and closes all else. @param {HTMLElement | undefined} wanted */
  function show(wanted) {
    for (const button of buttons) {
      button.setAttribute('aria-expanded', String(button === wanted))
      for (const id of idsOf(button)) document.getElementById(id)?.classList.toggle('open', button === wanted)
    }
    place.hidden = !wanted
    shown(wanted ? idsOf(wanted) : [])
    if (wanted) strip.scrollIntoView({ block: 'start' })
  }

  function close() {
    const opener = buttons.find(isOpen)
    show(undefined)
    opener?.focus()
  }

  // The program beside its path, for those who want it.
  const text = find(document.body, '.show-text')
  text.addEventListener('click', () => text.setAttribute('aria-pressed', String(find(document.body, '#path').classList.toggle('with-text'))))

  for (const button of buttons) button.addEventListener('click', () => show(isOpen(button) ? undefined : button))
  find(place, '.close').addEventListener('click', close)
  place.addEventListener('keydown', (event) => {
    // A chart takes its own cursor away first.
    if (event.key === 'Escape' && !(event.target instanceof Element && event.target.closest('.plot, .curve, textarea'))) close()
  })

  return {
    /** Opens a panel by its id, and brings it in sight. @param {string} id */
    open(id) {
      show(buttons.find((button) => idsOf(button).includes(id)))
    },
    /** Opens a panel, and brings it in sight again when it has what it shows, if nobody has gone elsewhere. @param {string} id @param {() => boolean} isThere */
    reveal(id, isThere) {
      const opener = buttons.find((button) => idsOf(button).includes(id))
      if (!opener || !isOpen(opener)) show(opener)
      awaited = isThere
      // Of several panels the first has the buttons above it.
      target = opener && idsOf(opener)[0] !== id ? find(document.body, `#${id}`) : strip
    },
    update() {
      if (awaited?.()) {
        awaited = undefined
        requestAnimationFrame(() => target.scrollIntoView({ block: 'start' }))
      }
      for (const button of buttons) button.hidden = idsOf(button).every((id) => document.getElementById(id)?.hidden)
      const opener = buttons.find(isOpen)
      if (opener?.hidden) show(undefined)
    },
  }
}
