// Every ISO program at hand gives the command line's times on the page; those that lie outside the project are
// skipped, plainly, where they are absent.

import assert from 'node:assert/strict'
import { existsSync, readdirSync } from 'node:fs'
import { basename, join } from 'node:path'
import { ROOT, assertAsPredicted, computed, longTest } from './steps.mjs'

const SHARED = join(ROOT, '../shared')
const FOLDERS = ['fanuc_haas', 'linuxcnc', 'camotics', 'grbl', 'mach3'].map((folder) => join(SHARED, 'gcode', folder))
FOLDERS.push(join(SHARED, 'recordings/nist-hurco/programs'))
const programs = FOLDERS.filter(existsSync).flatMap((folder) => readdirSync(folder).map((name) => join(folder, name)))

/** A subprogram that stands on the arguments of its caller: all of it is remarks. */
const WITHOUT_MOTION = ['gcode__3003.nc']

longTest(
  'every ISO program gives curves and the times of the command line',
  async ({ page }) => {
    await page.setInputFiles('#files', programs)
    // The page has its own order: by the numbers in names.
    const left = new Map(programs.map((program) => [basename(program), program]))
    for (let index = 0; left.size > 0; index += 1) {
      await page.click(`.choose >> nth=${index}`)
      const name = await page.textContent(`.choose >> nth=${index} >> .file`)
      const program = left.get(name)
      assert.ok(program && left.delete(name), `${name} is shown once`)
      if (WITHOUT_MOTION.includes(basename(program))) {
        await page.waitForSelector('.moves-nothing #diagnostics tbody tr', { state: 'attached' })
      } else {
        await computed(page)
        await assertAsPredicted(page, program)
      }
    }
  },
  { skip: programs.length > 0 ? false : `no programs of others in ${SHARED}/gcode; the recorded corpus (docs/fuzzing.md) provides them` },
)
