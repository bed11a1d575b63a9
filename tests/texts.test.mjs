// All texts of the page are in www/texts.js and www/texts_later.js: index.html names them, and no script says one of its own.

import assert from 'node:assert/strict'
import { readdirSync, readFileSync } from 'node:fs'
import { test } from 'node:test'
import { fileURLToPath } from 'node:url'
import ts from 'typescript'
import { textOf } from '../www/texts.js'
import { say } from '../www/texts_later.js'

const PAGE = fileURLToPath(new URL('../www/', import.meta.url))
const html = readFileSync(`${PAGE}index.html`, 'utf8')
/** The texts themselves, and what answers other programs. */
const ELSEWHERE = /^texts(_later)?\.js$|^embed\/(protocol|request|module|sheet)\.js$/
const scripts = ['', 'panels/', 'embed/', 'cutting/', 'job/', 'state/'].flatMap((folder) =>
  readdirSync(PAGE + folder).flatMap((name) => (name.endsWith('.js') && !ELSEWHERE.test(folder + name) ? [folder + name] : [])),
)
const LETTERS = /[A-Za-z]{2}/
/** What people read and what takes it. */
const SAID = /^(textContent|innerText|title|placeholder|ariaLabel|alt)$/
const SAID_AS = /^(aria-label|aria-description|title|placeholder|alt)$/
/** What no person reads, though it has blanks or a capital: selectors, names of classes, keys, addresses. */
const UNREAD = /^(find|querySelector|querySelectorAll|matches|matchMedia|closest|addEventListener|startsWith|includes|get|Error|refused|QuoteError)$/
const NAMES = /^(className|id|role|type|kind|mode|message)$/
/** A selector of elements. */
const SELECTOR = /\[[\w-]+=/
/** Units, and what has one name in all languages. */
const UNITS = /^(mm|mm\/min|mm³\/min|cm³\/min|N|N·m|W|s|µm|G-code|SVG|PNG|[XYZ]|K_[tra][ce])$/

/** Words of a literal, with ${} for what is put in it. @param {ts.Node} node */
function wordsOf(node) {
  if (ts.isStringLiteral(node) || ts.isNoSubstitutionTemplateLiteral(node)) return node.text
  return ts.isTemplateExpression(node) ? [node.head.text, ...node.templateSpans.map(({ literal }) => literal.text)].join('${}') : undefined
}

/** Whether a node is put where people read it. @param {ts.Node} node @returns {boolean} */
function isRead(node) {
  const { parent } = node
  if (ts.isConditionalExpression(parent)) return parent.condition !== node && isRead(parent)
  if (ts.isParenthesizedExpression(parent)) return isRead(parent)
  if (ts.isPropertyAssignment(parent)) return SAID.test(parent.name.getText())
  if (ts.isBinaryExpression(parent)) {
    if (/^[+|?]/.test(parent.operatorToken.getText())) return isRead(parent)
    return parent.right === node && ts.isPropertyAccessExpression(parent.left) && SAID.test(parent.left.name.text)
  }
  if (!ts.isCallExpression(parent)) return false
  const called = parent.expression.getText()
  const index = parent.arguments.indexOf(/** @type {ts.Expression} */ (node))
  if (called.endsWith('.setAttribute')) return index === 1 && SAID_AS.test(wordsOf(parent.arguments[0]) ?? '')
  return (called === 'make' && index >= 2) || /\.(append|prepend|replaceChildren)$/.test(called)
}

/** Whether a node names something to the browser. @param {ts.Node} node */
function isUnread({ parent }) {
  if (ts.isImportDeclaration(parent) || ts.isElementAccessExpression(parent)) return true
  if (ts.isPropertyAssignment(parent)) return NAMES.test(parent.name.getText())
  if (ts.isBinaryExpression(parent)) return /^[!=]==$/.test(parent.operatorToken.getText())
  if (ts.isConditionalExpression(parent)) return isUnread(parent)
  return (ts.isCallExpression(parent) || ts.isNewExpression(parent)) && UNREAD.test(parent.expression.getText().split('.').at(-1) ?? '')
}

/** The literals of a script that people would read. @param {string} name @param {string} source */
function literals(name, source) {
  const file = ts.createSourceFile(name, source, ts.ScriptTarget.ES2022, true)
  /** @type {string[]} */
  const found = []
  const visit = (/** @type {ts.Node} */ node) => {
    const words = wordsOf(node)
    if (words !== undefined && !UNITS.test(words.replaceAll('${}', '').trim()) && LETTERS.test(words) && !SELECTOR.test(words)) {
      const isSentence = /[a-z,;:.…’]\s+[A-Za-z]/.test(words) || /^[A-Z][a-z]/.test(words)
      if (isRead(node) || (isSentence && !isUnread(node))) found.push(`${name}: ${words}`)
    }
    ts.forEachChild(node, visit)
  }
  visit(file)
  return found
}

test('no script says a text of its own', () => {
  const planted = "make('p', {}, 'rapid'); a.textContent = `Hello ${name}`; b.setAttribute('aria-label', ok ? 'yes' : say.no); f('Not here.')"
  assert.equal(literals('planted', planted).length, 4, 'the rule finds nothing')
  assert.deepEqual(
    scripts.flatMap((name) => literals(name, readFileSync(PAGE + name, 'utf8'))),
    [],
  )
})

/** The tags of the page, and the text after each. */
const tags = [...html.slice(html.indexOf('<title')).matchAll(/<(\/?\w+)((?:\s[^>]*)?)>([^<]*)/g)].map(([, name, inside, text]) => ({
  name,
  text: text.trim(),
  attributes: Object.fromEntries([...inside.matchAll(/([\w-]+)="([^"]*)"/g)].map(([, key, value]) => [key, value])),
}))

test('the page names its texts, and what it shows at once is as they are', () => {
  /** @type {string[]} */
  const faults = []
  let isScriptless = false
  for (const { name, text, attributes } of tags) {
    if (name.endsWith('noscript')) isScriptless = name === 'noscript'
    const shown = { 'data-text': LETTERS.test(text) ? text : '', 'data-label': attributes['aria-label'], 'data-title': attributes.title, 'data-placeholder': attributes.placeholder }
    for (const [place, own] of Object.entries(shown)) {
      const key = attributes[place]
      if (own && !isScriptless && (!key || textOf(key) !== own)) faults.push(`${own} is not ${key ?? `in any ${place}`}`)
    }
  }
  assert.deepEqual(faults, [])
})

test('no style says a text', () => {
  const contents = [...readFileSync(`${PAGE}style.css`, 'utf8').matchAll(/[{; ]content:\s*("[^"]*")/g)].map(([, text]) => text)
  assert.ok(contents.length > 0)
  assert.deepEqual(
    contents.filter((text) => LETTERS.test(text)),
    [],
  )
})

test('every text is said somewhere', () => {
  const sources = scripts.map((name) => readFileSync(PAGE + name, 'utf8')).join('\n')
  const isSaid = (/** @type {string} */ key) => sources.includes(`say.${key}`) || html.includes(`="${key}"`) || key.startsWith('stages.')
  const keys = Object.entries(say).flatMap(([group, texts]) => Object.keys(texts).map((name) => `${group}.${name}`))
  assert.ok(keys.length > 300)
  assert.deepEqual(
    keys.filter((key) => !isSaid(key)),
    [],
  )
})
