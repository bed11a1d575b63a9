// What needs no browser of jobs: the order of operations, the text of a job, what is found in folders and archives.

import assert from 'node:assert/strict'
import { test } from 'node:test'
import { opened, planned, written } from '../www/job/document.js'
import { chosen, filesOf, inside, MOST_FILES } from '../www/job/dropped.js'
import { found } from '../www/job/jobs.js'
import { moved } from '../www/job/order.js'

test('an entry that is moved takes its place and the others keep their order', () => {
  const list = ['a', 'b', 'c', 'd']
  assert.deepEqual(moved(list, 0, 2), ['b', 'c', 'a', 'd'])
  assert.deepEqual(moved(list, 3, 0), ['d', 'a', 'b', 'c'])
  assert.deepEqual(moved(list, 1, 9), ['a', 'c', 'd', 'b'])
  for (const [from, to] of [
    [1, 1],
    [0, -4],
    [3, 7],
    [9, 0],
    [-1, 2],
  ])
    assert.equal(moved(list, from, to), list)
  assert.deepEqual(list, ['a', 'b', 'c', 'd'], 'it is another list')
})

const form = {
  fields: [
    { key: 'name', neutral: '' },
    { key: 'rates.hourly', neutral: 0 },
    { key: 'times.m_codes', neutral: null },
  ],
  presets: [],
  version: '',
}
const machine = { name: 'mill', 'rates.hourly': 80, 'times.m_codes': null }

test('what is open becomes a job and comes back', () => {
  const other = { name: 'other', 'rates.hourly': 40, 'times.m_codes': { M8: 2 } }
  const operations = [
    { name: 'op10.nc', title: 'Face', dialect: 'iso absolute', machine: null, setUp: 20, loading: null, column: 0.01, text: 'G1 X1 F100' },
    { name: 'op20.nc', title: '', dialect: null, machine: { start: 'other', values: other }, setUp: null, loading: 0, column: null },
  ]
  const job = { job: 'Bracket', fixture: 4, letter: { customer: 'A', number: '' }, company: {} }
  const text = written(job, operations, { values: machine, terms: { quantity: 25, uncertainty_percent: null } })
  assert.equal(Object.keys(text)[0], 'truefeed_job', 'a file is known by its beginning')
  assert.deepEqual(text.operations[0], { program: 'op10.nc', name: 'Face', tolerance_mm: 0.01, dialect: 'iso', arc_centres: 'absolute', set_up_min: 20, text: 'G1 X1 F100' })
  assert.deepEqual(text.operations[1], { program: 'op20.nc', machine: other, tolerance_mm: null, loading_s: 0 })
  assert.deepEqual([text.fixture, text.terms, text.offer], [{ parts: 4 }, { quantity: 25 }, { customer: 'A' }])
  // As Rust gives it back: each operation says everything itself.
  const read = { ...text, operations: text.operations.map((one) => ({ machine: text.machine, fixture: text.fixture, ...one })) }
  const back = opened(read, form)
  assert.deepEqual([back.job, back.fixture, back.values, back.tolerance], ['Bracket', 4, machine, 0.01])
  assert.deepEqual(
    back.operations.map((one) => one.tolerance),
    [null, 'programmed'],
  )
  assert.deepEqual(
    back.operations.map(({ name, title, dialect }) => [name, title, dialect]),
    [
      ['op10.nc', 'Face', 'iso absolute'],
      ['op20.nc', '', null],
    ],
  )
  assert.deepEqual(
    back.operations.map((one) => one.machine),
    [null, { start: 'other', values: other }],
  )
  assert.deepEqual(
    back.operations.map(({ setUp, loading }) => [setUp, loading]),
    [
      [20, null],
      [null, 0],
    ],
  )
})

test('a job is priced when all of its programs are computed', () => {
  const run = { summary: { tolerance_mm: 0.01, breakdown: {}, operations: [], trust: { seconds_in_doubt: 0, bounded: true }, lost: {} } }
  const summary = { programmed_time_s: 12, diagnostics: [{ severity: 'error' }, { severity: 'info' }] }
  const done = { found: 'FACE', outcome: { summary, runs: new Map([[0.01, run]]) } }
  const [one] = planned([done], () => 0.01)
  assert.deepEqual([one.title, one.programmed_time_s, one.remarks, 'lost' in one], ['FACE', 12, { errors: 1, warnings: 0 }, false])
  assert.equal(
    planned([done, { outcome: null }], () => 0.01),
    null,
  )
  assert.equal(
    planned([done], () => 0.02),
    null,
  )
})

/** A folder as a browser hands it out, a few entries at a time. */
function folder(path, children) {
  const entries = Object.entries(children).map(([name, child]) => {
    const fullPath = `${path}/${name}`
    return typeof child === 'string' ? { isDirectory: false, name, fullPath, file: (done) => done(new File([child], name)) } : folder(fullPath, child)
  })
  const createReader = () => {
    let at = 0
    return { readEntries: (done) => done(entries.slice(at, (at += 2))) }
  }
  return { isDirectory: true, name: path.split('/').pop(), fullPath: path, createReader }
}

const dropped = (...all) => all.map((one) => (one instanceof File ? { entry: null, file: one } : { entry: one, file: null }))

test('a folder is gone through, in the order of its numbers, without what is hidden', async () => {
  const part = folder('/part', { 'op10.nc': '10', 'op2.nc': '2', '.git': { config: '' }, deep: { 'op1.nc': '1' }, 'Thumbs.db': '?', '.DS_Store': '?' })
  const found = await filesOf(dropped(part, new File(['x'], 'alone.nc')))
  assert.deepEqual(
    found.map(({ path, named }) => [path, named]),
    [
      ['alone.nc', true],
      ['part/deep/op1.nc', false],
      ['part/op2.nc', false],
      ['part/op10.nc', false],
    ],
  )
  assert.equal(await found[3].file.text(), '10')
  const many = Object.fromEntries(Array.from({ length: 1000 }, (_, index) => [`${index}.nc`, 'G1']))
  assert.equal((await filesOf(dropped(folder('/many', many)))).length, MOST_FILES)
})

test('an archive gives its files, and a chosen folder those in it', async () => {
  const files = { 'part/op10.nc': 'G1', '__MACOSX/part/._op10.nc': '?', 'part/op9.nc': 'G0' }
  const unpacked = { names: () => Object.keys(files), take: (index) => new TextEncoder().encode(Object.values(files)[index]) }
  const inArchive = inside('part.zip', unpacked)
  assert.deepEqual(
    inArchive.map(({ path, file }) => [path, file.name]),
    [
      ['part.zip/part/op9.nc', 'op9.nc'],
      ['part.zip/part/op10.nc', 'op10.nc'],
    ],
  )
  assert.equal(await inArchive[0].file.text(), 'G0')
  const file = (name, webkitRelativePath) => Object.assign(new File([''], name), { webkitRelativePath })
  assert.deepEqual(
    chosen([file('b.nc', ''), file('.x', 'p/.x'), file('a.nc', 'p/a.nc')]).map(({ path }) => path),
    ['b.nc', 'p/a.nc'],
  )
})

test('a kept job is found by its name, its customer and its programs', () => {
  const job = (name, customer, program) => ({ id: name, name, customer, saved: 0, about: '', text: '', programs: [{ name: program, file: new Blob() }] })
  const jobs = [job('Bracket', 'Acme', 'op10.nc'), job('Plate', 'Baker', 'op20.nc')]
  const names = (wanted) => found(jobs, wanted).map(({ name }) => name)
  assert.deepEqual([names(''), names(' brack '), names('OP20 baker'), names('acme op20')], [['Bracket', 'Plate'], ['Bracket'], ['Plate'], []])
})
