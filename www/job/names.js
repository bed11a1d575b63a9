// What an operation of a job is called.

/** @import { Program } from "../types.js" */

/** By the estimator, else by the program, else as its file. @param {Program} program */
export const nameOf = ({ title, found, name }) => title || found || name
