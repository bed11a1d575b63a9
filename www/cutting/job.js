// A cutting job as its form holds it: what is cut and with what. Its text is TOML, as the command reads it; Rust says what is wrong.

/** @import { Operation, Outcome } from "../types.js" */

/** A tool of the form; `number` is null where the program names none. @typedef {{number: number | null, name: string, diameter: number | null, teeth: number | null, least: number | null, most: number | null, force: number | null}} ToolEntry */
/** What the form holds: lengths in mm, feeds per tooth in mm, power in W. @typedef {{material: string, stock: [number | null, number | null][], tools: ToolEntry[], power: number | null}} CuttingForm */
/** A tool as a program describes it; Rust reads its comments. @typedef {{tool: number, name: string, diameter_mm: number | null, teeth: number | null}} Described */

/** Below this feed per tooth an edge rubs, where nobody says otherwise, mm. */
const RUBS_BELOW_MM = 0.01
const STEPS_PER_MM = 10

/** A form to begin with: tools as the program describes them, the stock as the box of what is cut. @param {Outcome} outcome @param {Operation[]} operations @param {Described[]} described @param {string} material @returns {CuttingForm} */
export function formFor(outcome, operations, described, material) {
  const numbers = [...new Set(operations.filter(({ blocks }) => blocks > 0).map(({ tool }) => tool))]
  const tools = (numbers.length > 0 ? numbers : [null]).map((number) => {
    const known = described.find(({ tool }) => tool === number)
    const named = operations.find(({ tool, tool_name: name }) => tool === number && name)?.tool_name ?? ''
    return { number, name: (known?.name || named).split('|')[0].trim(), diameter: known?.diameter_mm ?? null, teeth: known?.teeth ?? null, least: RUBS_BELOW_MM, most: null, force: null }
  })
  return { material, stock: boxOf(outcome), tools, power: null }
}

/** The box around what is run in feed; its top is 0 where the path goes below that. @param {Outcome} outcome @returns {[number | null, number | null][]} */
function boxOf({ steps, trail }) {
  const low = [Infinity, Infinity, Infinity]
  const high = [-Infinity, -Infinity, -Infinity]
  let step = 0
  for (const [index, distance] of trail.distance.entries()) {
    while (step < steps.end.length - 1 && steps.end[step] < distance) step += 1
    if (steps.rapid[step]) continue
    for (let axis = 0; axis < 3; axis += 1) {
      const value = trail.points[3 * index + axis]
      low[axis] = Math.min(low[axis], value)
      high[axis] = Math.max(high[axis], value)
    }
  }
  if (!Number.isFinite(low[0]))
    return [
      [null, null],
      [null, null],
      [null, null],
    ]
  if (low[2] < 0) high[2] = 0
  return [0, 1, 2].map((axis) => [Math.floor(low[axis] * STEPS_PER_MM) / STEPS_PER_MM, Math.ceil(high[axis] * STEPS_PER_MM) / STEPS_PER_MM])
}

/** The job as TOML; what is not filled in is left out. @param {CuttingForm} form */
export function tomlOf({ material, stock, tools, power }) {
  const entry = (/** @type {string} */ key, /** @type {number | null} */ value) => (value === null ? [] : [`${key} = ${value}`])
  const isFull = stock.every(([from, to]) => from !== null && to !== null)
  const corner = (/** @type {0 | 1} */ end) => stock.map((ends) => ends[end]).join(', ')
  const lines = [
    `material = ${JSON.stringify(material)}`,
    ...(isFull ? ['', '[stock]', `min_mm = [${corner(0)}]`, `max_mm = [${corner(1)}]`] : []),
    ...tools.flatMap(({ number, name, diameter, teeth, most, force }) => [
      '',
      `[${number === null ? 'tool' : `tools.${number}`}]${name ? `  # ${name}` : ''}`,
      ...entry('diameter_mm', diameter),
      ...entry('teeth', teeth),
      ...entry('max_chip_mm', most),
      ...entry('max_force_n', force),
    ]),
    ...(power === null ? [] : ['', '[spindle]', `max_power_w = ${power}`]),
  ]
  return `${lines.join('\n')}\n`
}

/** How a tooth is fed. */
export const FEEDS = /** @type {const} */ (['none', 'within', 'rubbing', 'overload'])

/** A stretch of the path that is fed alike, by its place in FEEDS. @typedef {{end: number, feed: number}} Fed */

/**
 * Where teeth rub and where they are overloaded, along the path.
 * @param {ArrayLike<number>} distance  mm
 * @param {ArrayLike<number>} perTooth  mm; 0 where nothing is cut
 * @param {readonly ToolEntry[]} tools
 * @param {readonly Operation[]} operations
 */
export function fedAlong(distance, perTooth, tools, operations) {
  /** @type {Fed[]} */
  const stretches = []
  /** @type {Map<ToolEntry, {largest: number, cut: number, rubbing: number, overload: number, first: Partial<Record<"rubbing" | "overload", number>>}>} */
  const byTool = new Map()
  let operation = 0
  for (let index = 1; index < distance.length; index += 1) {
    const at = distance[index]
    while (operation < operations.length - 1 && operations[operation].distance_mm[1] < at) operation += 1
    const number = operations[operation]?.tool ?? null
    const tool = tools.find((one) => one.number === number) ?? tools[0]
    const feed = perTooth[index]
    const kind = !tool || feed === 0 ? 0 : tool.most !== null && feed > tool.most ? 3 : tool.least !== null && feed < tool.least ? 2 : 1
    const last = stretches.at(-1)
    if (last?.feed === kind) last.end = at
    else stretches.push({ end: at, feed: kind })
    if (!tool || kind === 0) continue
    const own = byTool.get(tool) ?? { largest: 0, cut: 0, rubbing: 0, overload: 0, first: {} }
    byTool.set(tool, own)
    const length = at - distance[index - 1]
    own.cut += length
    own.largest = Math.max(own.largest, feed)
    const name = FEEDS[kind]
    if (name === 'rubbing' || name === 'overload') {
      own[name] += length
      own.first[name] ??= at
    }
  }
  return { stretches, byTool }
}
