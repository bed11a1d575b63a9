// The form of a cutting job: material, stock and tools as fields, and the same as text for whoever has it as a file.

import { make } from '../dom.js'
import { parsed, typed } from '../format.js'
import { saveFile } from '../save.js'
import { say } from '../texts_later.js'
import { tomlOf } from './job.js'

/** @import { CuttingForm, ToolEntry } from "./job.js" */

/** The columns of the tools that are numbers. @type {[keyof ToolEntry, string][]} */
const OF_TOOL = [
  ['diameter', say.cutting.diameter],
  ['teeth', say.cutting.teeth],
  ['least', say.cutting.least],
  ['most', say.cutting.most],
  ['force', say.cutting.mostForce],
]

/** @param {HTMLElement} root @param {{word: string, name: string}[]} materials @param {() => void} changed */
export function mountForm(root, materials, changed) {
  const place = make('div', { className: 'entries' })
  const text = make('textarea', { rows: 15, spellcheck: false })
  text.setAttribute('aria-label', say.cutting.job)
  const file = make('input', { type: 'file', className: 'away', id: 'cutting-file', accept: '.toml,text/plain' })
  const open = make('label', { className: 'button', htmlFor: file.id }, say.cutting.openFile)
  const save = button(say.cutting.saveFile, () => saveFile(text.value, 'application/toml', 'cutting.toml'))
  const back = button(say.cutting.backToForm, () => show(form))
  const asText = make('details', { className: 'as-text' }, make('summary', {}, say.cutting.asText), text, make('p', { className: 'choices' }, save, open, file, back))
  root.append(place, asText)
  /** @type {CuttingForm | null} */
  let form = null
  /** Whether the text is the job, and the form is not. */
  let isText = false

  text.addEventListener('input', () => {
    written(true)
    changed()
  })
  file.addEventListener('change', async () => {
    const [chosen] = file.files ?? []
    file.value = ''
    if (!chosen) return
    text.value = await chosen.text()
    asText.open = true
    written(true)
    changed()
  })

  /** @param {boolean} now */
  function written(now) {
    isText = now
    back.hidden = !isText || !form
    place.inert = isText
    place.classList.toggle('unused', isText)
  }

  /** The form, or the text, has another value. */
  function heard() {
    if (form) text.value = tomlOf(form)
    changed()
  }

  /** @param {string} label @param {number | null} value @param {(value: number | null) => void} take */
  function number(label, value, take) {
    const input = make('input', { inputMode: 'decimal', value: value === null ? '' : typed(value) })
    input.setAttribute('aria-label', label)
    input.addEventListener('input', () => {
      const written = input.value.trim()
      const own = written === '' ? null : parsed(written)
      const isWrong = own !== null && !Number.isFinite(own)
      input.ariaInvalid = isWrong ? 'true' : null
      if (isWrong) return
      take(own)
      heard()
    })
    return input
  }

  /** @param {CuttingForm} own */
  function stockTable(own) {
    const rows = own.stock.map((ends, axis) => {
      const name = 'XYZ'[axis]
      const cells = [say.cutting.from, say.cutting.to].map((title, end) =>
        make(
          'td',
          {},
          number(`${say.cutting.stock} ${name} ${title}`, ends[end], (value) => (ends[end] = value)),
        ),
      )
      return make('tr', {}, make('th', { scope: 'row' }, name), ...cells)
    })
    return titled(say.cutting.stockHelp, ['', say.cutting.from, say.cutting.to], rows)
  }

  /** @param {CuttingForm} own */
  function toolTable(own) {
    const rows = own.tools.map((tool) => {
      const called = tool.number === null ? say.charts.noTool : `T${tool.number}`
      const cells = OF_TOOL.map(([key, title]) =>
        make(
          'td',
          {},
          number(`${called} ${title}`, /** @type {number | null} */ (tool[key]), (value) => Object.assign(tool, { [key]: value })),
        ),
      )
      return make('tr', {}, make('th', { scope: 'row' }, called), make('td', { className: 'name' }, tool.name), ...cells)
    })
    return titled(say.cutting.toolsHelp, [say.breakdown.tool, say.breakdown.name, ...OF_TOOL.map(([, title]) => title)], rows)
  }

  /** @param {CuttingForm | null} own */
  function show(own) {
    form = own
    written(false)
    if (!own) return place.replaceChildren()
    const material = make('select', { id: 'cutting-material' }, ...materials.map(({ word, name }) => make('option', { value: word }, name)))
    material.value = own.material
    material.addEventListener('change', () => {
      own.material = material.value
      heard()
    })
    const power = number(say.cutting.spindleMost, own.power, (value) => (own.power = value))
    place.replaceChildren(
      make('p', { className: 'line' }, make('label', { htmlFor: material.id }, say.cutting.material), ' ', material, ' ', make('label', {}, say.cutting.spindleMost, ' ', power)),
      stockTable(own),
      toolTable(own),
    )
    text.value = tomlOf(own)
  }

  return {
    show,
    /** The job as text. */
    text: () => text.value,
    /** The tools of the form; none where the text is the job. @returns {ToolEntry[]} */
    tools: () => (isText || !form ? [] : form.tools),
    isText: () => isText,
  }
}

/** @param {string} text @param {() => void} act */
function button(text, act) {
  const element = make('button', { type: 'button' }, text)
  element.addEventListener('click', act)
  return element
}

/** @param {string} caption @param {string[]} titles @param {HTMLElement[]} rows */
function titled(caption, titles, rows) {
  const heads = titles.map((title) => (title ? make('th', { scope: 'col' }, title) : make('td', {})))
  const table = make('table', {}, make('caption', {}, caption), make('thead', {}, make('tr', {}, ...heads)), make('tbody', {}, ...rows))
  return make('div', { className: 'scroll' }, table)
}
