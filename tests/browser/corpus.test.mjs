// Every ISO program at hand gives the command line's times on the page; those that lie outside the project are
// skipped, plainly, where they are absent.

import { existsSync, readdirSync } from 'node:fs'
import { basename, join } from 'node:path'
import { ROOT, assertAsPredicted, computed, longTest } from './steps.mjs'

const SHARED = join(ROOT, '../shared')
const FOLDERS = ['fanuc_haas', 'linuxcnc', 'camotics', 'grbl', 'mach3'].map((folder) => join(SHARED, 'gcode', folder))
FOLDERS.push(join(SHARED, 'recordings/nist-hurco/programs'))
/** In the order in which the page shows them: by the numbers in their names. */
const programs = FOLDERS.filter(existsSync)
  .flatMap((folder) => readdirSync(folder).map((name) => join(folder, name)))
  .sort((one, other) => basename(one).localeCompare(basename(other), 'en', { numeric: true }))

/** A subprogram that stands on the arguments of its caller: all of it is remarks. */
const WITHOUT_MOTION = ['gcode__3003.nc']

longTest(
  'every ISO program gives curves and the times of the command line',
  async ({ page }) => {
    await page.setInputFiles('#files', programs)
    for (const [index, program] of programs.entries()) {
      await page.click(`.choose >> nth=${index}`)
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
