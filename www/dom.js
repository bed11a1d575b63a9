// Finding and making elements, and putting the texts in their places.

import { say, textOf } from './texts.js'

/**
 * The element a panel cannot do without.
 * @template {HTMLElement} [T=HTMLElement]
 * @param {HTMLElement} root
 * @param {string} selector
 * @returns {T}
 */
export function find(root, selector) {
  const found = root.querySelector(selector)
  if (!found) throw new Error(`the page has no ${selector}`)
  return /** @type {T} */ (found)
}

/**
 * A new element with properties and children.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} name
 * @param {Partial<HTMLElementTagNameMap[K]>} properties
 * @param {...(Node | string)} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function make(name, properties, ...children) {
  const element = Object.assign(document.createElement(name), properties)
  element.append(...children)
  return element
}

/**
 * Gives a choice its options, and chooses one, or none where it is not offered.
 * @param {HTMLSelectElement} select
 * @param {string[][]} choices  value, text
 * @param {string} chosen
 */
export function offer(select, choices, chosen) {
  const offered = JSON.stringify(choices)
  if (select.dataset.offered !== offered) select.replaceChildren(...choices.map(([value, text]) => make('option', { value }, text)))
  select.dataset.offered = offered
  select.value = chosen
}

/** Writes a text where it is another one: what is read out is not said again. @param {Element} element @param {string} text */
export function write(element, text) {
  if (element.textContent !== text) element.textContent = text
}

/** A wide table that scrolls in itself, by keys as well. @param {HTMLTableElement} table */
export function scroll(table) {
  const element = make('div', { className: 'scroll', tabIndex: 0 }, table)
  element.setAttribute('role', 'group')
  element.setAttribute('aria-label', table.caption?.textContent || say.charts.table)
  return element
}

/** Where a text goes: what an element carries, and the attribute that it is put in. */
const PLACES = /** @type {const} */ ([
  ['data-label', 'aria-label'],
  ['data-title', 'title'],
  ['data-placeholder', 'placeholder'],
])

/** Puts the texts in their places. What is seen at once stands there already, in English. @param {Document} page */
export function fillTexts(page) {
  for (const element of page.querySelectorAll('[data-text]')) element.textContent = textOf(element.getAttribute('data-text') ?? '')
  page.documentElement.style.setProperty('--out-of-date', JSON.stringify(say.charts.outOfDate))
  for (const [key, attribute] of PLACES) for (const element of page.querySelectorAll(`[${key}]`)) element.setAttribute(attribute, textOf(element.getAttribute(key) ?? ''))
}
