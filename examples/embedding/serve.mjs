// Serves the examples:  scripts/build && node examples/embedding/serve.mjs
//
// Two servers, so that the portal is of another origin than the frame it embeds, as it would be on the network.

import { argv } from 'node:process'
import { fileURLToPath } from 'node:url'
import { serve } from '../../scripts/serve.mjs'

const HERE = fileURLToPath(new URL('.', import.meta.url)).replace(/[/\\]$/, '')
const PAGE = fileURLToPath(new URL('../../www', import.meta.url))

/** The plain page has the component's files beside its own; the portal has none of them. */
export const servePlainPage = (port = 0) => serve(port, [HERE, PAGE])
export const servePortal = (port = 0) => serve(port, [HERE])

if (argv[1] === fileURLToPath(import.meta.url)) {
  const plain = await servePlainPage()
  const portal = await servePortal()
  console.log(`A plain page with two components:        ${plain.origin}/page.html`)
  console.log(`A portal, with a frame of another origin: ${portal.origin}/portal.html?truefeed=${plain.origin}`)
}
