// Quotes every program of a folder, as a table in CSV:
//
//   scripts/build && scripts/package
//   node examples/embedding/folder.mjs FOLDER MACHINE [TOLERANCE_MM]...
//
// MACHINE is a machine file, or the name of a preset. Without tolerances those of each program hold.

import { existsSync } from 'node:fs'
import { readFile, readdir } from 'node:fs/promises'
import { join } from 'node:path'
import { argv } from 'node:process'

// As a dependency:  import { quote } from 'truefeed'
import { QuoteError, quote } from '../../target/npm/npm/node.js'

const [folder, machineName, ...toleranceWords] = argv.slice(2)
if (!machineName) {
  console.error('which programs and which machine? node folder.mjs FOLDER MACHINE [TOLERANCE_MM]...')
  process.exit(2)
}
const machine = existsSync(machineName) ? await readFile(machineName, 'utf8') : machineName
const tolerances = toleranceWords.map(Number)

console.log('program,tolerance_mm,programmed_s,cycle_time_s,price,remarks')
for (const entry of (await readdir(folder, { withFileTypes: true })).filter((entry) => entry.isFile())) {
  try {
    const program = await readFile(join(folder, entry.name))
    const { runs, programmed_time_s: programmed, diagnostics } = await quote(program, machine, tolerances, { name: entry.name })
    if (programmed === 0) console.error(`${entry.name}: there is no motion in it`)
    else
      for (const run of runs) {
        const numbers = [run.tolerance_mm, programmed.toFixed(2), run.cycle_time_s.toFixed(2), run.price.toFixed(2), diagnostics.length]
        console.log([JSON.stringify(entry.name), ...numbers].join(','))
      }
  } catch (error) {
    if (!(error instanceof QuoteError)) throw error
    console.error(`${entry.name}: ${error.message}`)
    process.exit(2)
  }
}
