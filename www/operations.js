// What tools and operations are called.

import { say } from './texts.js'

/** @import { Operation, Program } from "./types.js" */

/** The number of its tool. @param {Pick<Operation, 'tool'>} operation */
export const toolTitle = ({ tool }) => (tool === null ? say.charts.noTool : `T${tool}`)

/** The name of an operation, or else of its tool, or else where it begins. @param {Operation} operation */
export const operationTitle = ({ name, tool_name: tool, line }) => plain(name ?? tool) || say.charts.fromLine(line)

/** A name without what a post-processor adds to it behind a bar: 3" FACE MILL|H0|XY STOCK TO LEAVE. @param {string | null} name */
export const plain = (name) => (name ?? '').split('|')[0].trim()

/**
 * The operations of a program: what its head says names the program and not its first operation, which is called as its tool.
 * @param {Pick<Program, "found" | "described"> | undefined} program
 * @param {Operation[]} operations
 */
export function namedIn(program, operations) {
  const [first, ...others] = operations
  if (!first || !program?.found || first.name?.trim() !== program.found) return operations
  const tool = program.described?.find(({ tool }) => tool === first.tool)?.name
  return [{ ...first, name: tool ?? first.tool_name }, ...others]
}

/** The operation at a distance, mm. @param {Operation[]} operations  in order @param {number} distance */
export const operationAt = (operations, distance) => operations.find(({ distance_mm: [from, to] }) => from <= distance && distance <= to)
