// What the scenes of the gallery share: how a page is seen, how it is taken, and what is wrong with it.

import { violations } from './axe.mjs'
import { openContext } from './setup.mjs'

const DESK = { viewport: { width: 1280, height: 800 } }
const PHONE = { viewport: { width: 360, height: 740 }, hasTouch: true, isMobile: true }

/** How a page is seen. */
export const LOOKS = {
  'desk-light': { ...DESK, colorScheme: 'light' },
  'desk-dark': { ...DESK, colorScheme: 'dark' },
  'phone-light': { ...PHONE, colorScheme: 'light' },
  'phone-dark': { ...PHONE, colorScheme: 'dark' },
}

/** The height at which a long page is cut. */
const LONGEST = 2400

/** The pictures in the folder, and what is wrong with their pages. */
export class Gallery {
  taken = []
  defects = []

  constructor(browser, folder) {
    this.browser = browser
    this.folder = folder
  }

  /** Takes a page as it is; only the part that the window shows, because a dialog is in its middle; or one panel of a long page. */
  async take(page, scene, look, name, { whole = true, panel } = {}) {
    // The head of a page stays at the top of its window.
    if (whole) await page.evaluate(() => scrollTo(0, 0))
    await settled(page)
    const [width, height, overflow] = await page.evaluate(() => {
      const { clientWidth, scrollWidth, scrollHeight } = document.documentElement
      return [clientWidth, scrollHeight, scrollWidth - clientWidth]
    })
    if (overflow > 0) this.defects.push(`${scene} ${name} ${look}: ${overflow} pixels too wide`)
    const file = `${scene}-${name.replace(/\W+/g, '-').replace(/^-|-$/g, '') || 'overview'}-${look}.png`
    const box = (await panel?.boundingBox()) ?? { y: 0, height: Math.min(height, LONGEST) }
    const clip = whole ? { clip: { x: 0, y: box.y, width, height: box.height } } : {}
    await page.screenshot({ path: `${this.folder}/${file}`, fullPage: whole, ...clip })
    this.taken.push({ scene, name, look, file })
    for (const found of await violations(page)) this.defects.push(`${scene} ${name} ${look}: ${found}`)
  }

  /** Takes pages of a station in every look; `ready` waits until a page is as it should be. */
  async takeAll(station, scene, paths, { ready = isLive, more = {} } = {}) {
    for (const [look, options] of Object.entries(LOOKS)) {
      await this.open(scene, look, { ...options, ...more }, async (page) => {
        for (const path of paths) {
          await page.goto(station.url + path)
          await ready(page)
          await this.take(page, scene, look, path)
        }
      })
    }
  }

  /** Opens an empty page for `look`, and keeps what it complains about, apart from what is `expected`. */
  async open(scene, look, options, use, expected = /^$/) {
    const { page, complaints, close } = await openContext(this.browser, options)
    watch(page)
    await use(page)
    for (const complaint of complaints)
      if (!expected.test(complaint)) this.defects.push(`${scene} ${look}: ${complaint}`)
    await close()
  }
}

/** What is loaded after the page itself: nothing was asked for a while. The stream of the live values never ends. */
async function settled(page) {
  const begun = performance.now()
  for (let quiet = 0; quiet < QUIET_MS && performance.now() - begun < LONGEST_WAIT_MS; ) {
    await page.waitForTimeout(STEP_MS)
    quiet = pending.get(page)?.size ? 0 : quiet + STEP_MS
  }
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))))
}

const QUIET_MS = 200
const STEP_MS = 50
const LONGEST_WAIT_MS = 2_000

/** The requests of each page that have no answer yet. */
const pending = new WeakMap()

function watch(page) {
  const requests = new Set()
  pending.set(page, requests)
  page.on('request', (request) => !request.url().endsWith('/api/live') && requests.add(request))
  for (const end of ['requestfinished', 'requestfailed']) page.on(end, (request) => requests.delete(request))
}

export const isLive = (page) => page.locator('header .connection.good, .wall').first().waitFor()

/** Logs in where a page asks for it. */
export async function loggedIn(page, name = 'Erna') {
  await page.locator('form, header .connection.good').first().waitFor()
  if ((await page.getByLabel('Password', { exact: true }).count()) > 0) {
    await page.getByLabel('Name').fill(name)
    await page.getByLabel('Password', { exact: true }).fill('tin whisker plateau')
    await page.getByRole('button', { name: 'Log in' }).click()
  }
  await isLive(page)
}
