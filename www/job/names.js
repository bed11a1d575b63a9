// What operations are called.

/** @import { Program } from "../types.js" */

/** What the head of a program says of it; empty and null where nobody has looked yet. @typedef {Pick<Program, "found" | "described">} Head */

/** By the estimator, else by the program, else as its file. @param {Program} program */
export const nameOf = ({ title, found, name }) => title || found || name

/** @type {WeakMap<Blob, Head>} */
const heads = new WeakMap()

/** What is known of a file from its head, so that a program that comes back has its name at once. @param {Blob} file @returns {Head} */
export const headOf = (file) => heads.get(file) ?? { found: '', described: null }

/** Keeps what the head of a file says. @param {Blob} file @param {Head} head */
export const keepHead = (file, head) => void heads.set(file, head)
