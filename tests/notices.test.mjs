// The licences that the built modules carry: every crate that Cargo compiles into them is named in `www/pkg/notices.txt` with a
// text, and so is every one whose files a module names in its messages of panic.

import assert from 'node:assert/strict'
import { execFileSync } from 'node:child_process'
import { readFileSync } from 'node:fs'
import { dirname, join } from 'node:path'
import { test } from 'node:test'
import { fileURLToPath } from 'node:url'

const ROOT = dirname(dirname(fileURLToPath(import.meta.url)))
const read = (name, encoding) => readFileSync(join(ROOT, 'www/pkg', name), encoding)

/** Crate by crate what stands above its text: name, version and licence; and how long the text is. */
function noticed() {
  const parts = read('notices.txt', 'utf8')
    .split(/\n-{79}\n/)
    .slice(1)
  return parts.flatMap((part) => {
    const titles = part.slice(0, part.indexOf('\n\n')).split('\n')
    const text = part.slice(part.indexOf('\n\n')).trim()
    return titles.map((title) => {
      const [, name, version, licence] = title.match(/^(\S+) (\S+) \((.+)\)$/) ?? assert.fail(`no title of a crate: ${title}`)
      return { crate: `${name} ${version}`, licence, length: text.length }
    })
  })
}

test('the notices name every crate that the modules are made of, each with its licence', () => {
  const tree = ['tree', '--locked', '--target', 'wasm32-unknown-unknown', '--edges', 'normal,no-proc-macro', '--prefix', 'none']
  const lines = execFileSync('cargo', [...tree, '--format', '{p} {l}'], { cwd: ROOT, encoding: 'utf8' })
    .trim()
    .split('\n')
  const compiled = new Set(
    lines
      .map((line) =>
        line
          .match(/^(\S+) v(\S+)/)
          .slice(1, 3)
          .join(' '),
      )
      .filter((crate) => !crate.startsWith('truefeed ')),
  )
  const found = noticed()
  const named = new Set(found.map(({ crate }) => crate))
  assert.ok(20 < compiled.size, `${compiled.size} crates are compiled`)
  assert.deepEqual(
    [...compiled].filter((crate) => !named.has(crate)),
    [],
  )
  for (const { crate, licence, length } of found) {
    assert.notEqual(licence, 'no expression', crate)
    assert.ok(400 <= length, `the text of ${crate} has ${length} characters`)
  }
})

test('the notices name every crate that a module mentions', () => {
  const crates = new Set(noticed().map(({ crate }) => crate))
  for (const module of ['truefeed_bg.wasm', 'truefeed_whole_bg.wasm']) {
    const text = read(module, 'latin1')
    // Those below `/rust/deps` belong to the standard library, which the notices name as a whole.
    const paths = text.matchAll(/(\/rust\/deps)?[/\\]([a-z0-9_-]+?)-(\d+\.\d+\.\d+[a-z0-9.+-]*)[/\\]src[/\\]/g)
    const mentioned = [...paths].filter(([, isOfStandard]) => !isOfStandard).map(([, , name, version]) => `${name} ${version}`)
    assert.ok(mentioned.length > 0, `${module} mentions no crate`)
    for (const crate of mentioned) assert.ok(crates.has(crate), `${module} mentions ${crate}`)
  }
})
