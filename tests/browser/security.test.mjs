// The page can connect to nothing but its own files, neither itself nor its workers; and it works without a network.

import assert from 'node:assert/strict'
import { cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs'
import { createServer } from 'node:http'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after, test } from 'node:test'
import { serve } from '../../scripts/serve.mjs'
import { leaving, openPage } from './harness.mjs'
import { computed, cycleTimes, longPlainTest, pageTest, ROOT, shot } from './steps.mjs'

const scratch = mkdtempSync(join(tmpdir(), 'truefeed-security-'))
after(() => rmSync(scratch, { recursive: true }))

/** A server of another origin that lets everyone in, and counts who came. */
async function elsewhere() {
  const asked = []
  const server = createServer((request, response) => {
    // The browser asks every origin it visits for an icon, whenever it likes: that is no leak of the page.
    if (request.url !== '/favicon.ico') asked.push(request.url)
    response.writeHead(200, { 'Access-Control-Allow-Origin': '*', 'Content-Type': 'text/javascript' }).end('')
  })
  await new Promise((done) => server.listen(0, '127.0.0.1', done))
  server.on('upgrade', (request, socket) => {
    asked.push(request.url)
    socket.destroy()
  })
  return { asked, origin: `http://127.0.0.1:${server.address().port}`, close: () => server.close() }
}

/** Tries to reach an address in every way a script has; what came through, by name. */
const leaks = async (address) => {
  const reached = async (name, attempt) =>
    (await attempt().then(
      () => true,
      () => false,
    ))
      ? [name]
      : []
  const loads = (tag, key) => () =>
    new Promise((done, fail) => {
      const element = document.createElement(tag)
      element.onload = done
      element.onerror = fail
      if (tag === 'link') element.rel = 'stylesheet'
      element[key] = `${address}/${tag}`
      document.head.append(element)
      setTimeout(fail, 1000)
    })
  const socket = () =>
    new Promise((done, fail) => {
      const opened = new WebSocket(`${address.replace('http', 'ws')}/socket`)
      opened.onopen = done
      opened.onerror = fail
    })
  const events = () =>
    new Promise((done, fail) => {
      const source = new EventSource(`${address}/events`)
      source.onopen = done
      source.onerror = fail
    })
  const all = await Promise.all([
    reached('fetch', () => fetch(`${address}/fetch`, { method: 'POST', body: 'a program', mode: 'no-cors' })),
    reached('script', loads('script', 'src')),
    reached('style', loads('link', 'href')),
    // A refused frame loads a page that says so; the other side knows whether it was asked.
    reached('frame', () => loads('iframe', 'src')().then(() => Promise.reject())),
    reached('image', loads('img', 'src')),
    reached('import', () => import(`${address}/import.js`)),
    reached('socket', async () => socket()),
    reached('events', async () => events()),
    reached('form', async () => {
      const form = document.createElement('form')
      Object.assign(form, { action: `${address}/form`, method: 'post', target: '_blank' })
      document.body.append(form)
      form.submit()
      throw new Error('what comes of it shows on the other side')
    }),
  ])
  navigator.sendBeacon(`${address}/beacon`, 'a program')
  return all.flat()
}

for (const path of ['/', '/embed.html']) {
  test(`nothing gets out of ${path}, and inline script and style do nothing`, { timeout: 120_000 }, async () => {
    const [opened, other] = await Promise.all([openPage({ path }), elsewhere()])
    const { page } = opened
    try {
      await page.waitForLoadState('networkidle')
      // The other side can be reached where no policy forbids it, or this test shows nothing.
      const free = await page.context().newPage()
      await free.goto(`${other.origin}/free`)
      assert.deepEqual(await free.evaluate(leaks, other.origin).then((all) => all.includes('fetch')), true)
      // What is sent last arrives when it likes, and is not to be taken for what follows.
      while (!other.asked.includes('/beacon')) await free.waitForTimeout(20)
      await free.close()
      other.asked.length = 0

      assert.deepEqual(await page.evaluate(leaks, other.origin), [])
      const ran = await page.evaluate(async () => {
        const script = document.createElement('script')
        script.textContent = 'window.inlineRan = true'
        const style = document.createElement('style')
        style.textContent = 'body { opacity: 0.123 }'
        document.head.append(script, style)
        const text = document.createElement('div')
        text.innerHTML = '<img src="data:," onerror="window.inlineRan = true">'
        document.body.append(text)
        // What the tests run itself may evaluate text; what it starts may not.
        const evaluated = await new Promise((done) =>
          setTimeout(() => {
            try {
              done(new Function('return true')())
            } catch {
              done(false)
            }
          }),
        )
        return { script: window.inlineRan === true, style: getComputedStyle(document.body).opacity, evaluated }
      })
      assert.deepEqual(ran, { script: false, style: '1', evaluated: false })
      await page.waitForTimeout(200)
      assert.deepEqual(other.asked, [])
    } finally {
      await opened.close()
      other.close()
    }
  })
}

test('the worker of the page is under the policy of the page', { timeout: 120_000 }, async () => {
  const [opened, other] = await Promise.all([openPage(), elsewhere()])
  const { page } = opened
  try {
    await page.waitForSelector('html[data-ready]')
    await page.click('#welcome .sample')
    await computed(page)
    const reaches = (address) =>
      fetch(address, { mode: 'no-cors' }).then(
        () => true,
        () => false,
      )
    assert.equal(page.workers().length, 1)
    assert.equal(await page.workers()[0].evaluate(reaches, `${other.origin}/worker`), false)
    assert.deepEqual(other.asked, [])
    assert.deepEqual(
      leaving(
        opened.requests.filter((url) => !url.startsWith(other.origin)),
        opened.origin,
      ),
      [],
    )
  } finally {
    await opened.close()
    other.close()
  }
})

pageTest('the page says that it can connect to nothing else, and its files hold no inline script or style', async ({ page }) => {
  assert.match(await page.textContent('footer'), /can connect to nothing but its own files/)
  for (const name of ['index.html', 'embed.html']) {
    const text = readFileSync(join(ROOT, 'www', name), 'utf8')
    assert.doesNotMatch(text, /<style|\sstyle=|\son[a-z]+=|<script(?![^>]*\ssrc=)|javascript:/i, name)
    const policy = text.match(/Content-Security-Policy" content="([^"]+)"/)[1]
    const sources = Object.fromEntries(policy.split('; ').map((rule) => [rule.split(' ')[0], rule.split(' ').slice(1).join(' ')]))
    assert.equal(sources['default-src'], "'none'")
    assert.equal(sources['connect-src'], "'self'")
    assert.equal(sources['script-src'], "'self' 'wasm-unsafe-eval'")
    assert.equal(sources['style-src'], "'self'")
    assert.ok(text.indexOf('Content-Security-Policy') < text.indexOf('<link'), 'the policy stands before what it is for')
  }
})

/** What the service worker does is seen in the end only: when it has kept all files. */
const kept = (page) => page.waitForFunction(() => /without a network/.test(document.querySelector('#offline').textContent))

test('after one visit the page loads and quotes without a network', { timeout: 120_000 }, async () => {
  const server = await serve(0)
  const opened = await openPage()
  const { page } = opened
  try {
    await page.waitForLoadState('networkidle')
    await page.goto(`${server.origin}/`)
    await page.waitForSelector('html[data-ready]')
    await page.click('#welcome .sample')
    await computed(page)
    const times = await cycleTimes(page)
    await kept(page)

    const list = await page.evaluate(async () => [...(await (await caches.open((await caches.keys())[0])).keys())].map(({ url }) => url))
    const missing = opened.requests.filter((url) => url.startsWith(server.origin) && !list.includes(url.replace(/\/$/, '/index.html')))
    assert.deepEqual(
      [...new Set(missing)],
      [`${server.origin}/sw.js`].filter((url) => missing.includes(url)),
      'files that are not kept',
    )
    await server.close()

    // As a new tab would be, with nothing open.
    await page.evaluate(() => sessionStorage.clear())
    await page.reload()
    await page.waitForSelector('html[data-ready]')
    await page.click('#welcome .sample')
    await computed(page)
    assert.deepEqual(await cycleTimes(page), times)
    await shot(page, 'offline')
    assert.deepEqual(opened.errors, [])
  } finally {
    await opened.close()
    await server.close().catch(() => {})
  }
})

longPlainTest('a new version is taken when the page is loaded again', { timeout: 240_000 }, async () => {
  const folder = join(scratch, 'www')
  cpSync(join(ROOT, 'www'), folder, { recursive: true })
  const server = await serve(0, [folder])
  const opened = await openPage({ path: '/embed.html' })
  const { page } = opened
  try {
    await page.goto(`${server.origin}/`)
    await kept(page)
    const change = (file, from, to) => writeFileSync(join(folder, file), readFileSync(join(folder, file), 'utf8').replace(from, to))
    change('texts.js', "name: 'Truefeed'", "name: 'Truefeed, newer'")
    change('pkg/files.js', /"version":"\w+"/, '"version":"newer"')

    // This load is still of the old version, and finds the new one.
    await page.reload()
    assert.equal(await page.textContent('h1'), 'Truefeed')
    await page.evaluate(async () => {
      const registration = await navigator.serviceWorker.ready
      while (!registration.waiting) await new Promise((done) => setTimeout(done, 50))
    })
    // On a busy machine the browser may put the change off once, to the next load.
    const isNewer = () => page.waitForFunction(() => document.querySelector('h1')?.textContent === 'Truefeed, newer', null, { timeout: 40_000 })
    await page.reload()
    await isNewer().catch(async () => {
      await page.reload()
      await isNewer()
    })
    const caches_ = await page.evaluate(async () => {
      while ((await caches.keys()).length > 1) await new Promise((done) => setTimeout(done, 50))
      return caches.keys()
    })
    assert.deepEqual(caches_, ['truefeed-newer'])
  } finally {
    await opened.close()
    await server.close()
  }
})

longPlainTest('the page can be installed', { timeout: 120_000 }, async () => {
  const { page, close } = await openPage()
  try {
    await kept(page)
    const devtools = await page.context().newCDPSession(page)
    const { errors, url } = await devtools.send('Page.getAppManifest')
    assert.match(url, /manifest\.webmanifest$/)
    assert.deepEqual(errors, [])
    const { installabilityErrors } = await devtools.send('Page.getInstallabilityErrors')
    // The tests' profile is a private one, where nothing is ever installed.
    assert.deepEqual(
      installabilityErrors.filter(({ errorId }) => errorId !== 'in-incognito'),
      [],
    )
  } finally {
    await close()
  }
})
