// Takes pictures of every page, on a desk and on a phone, light and dark: at each act of the demonstration, of a plant with 15 gauges and
// of one with 480: `node gallery.mjs FOLDER [acts | plants]`. FOLDER/index.html shows them beside each other. Ends with 1 if a page can be scrolled
// sideways or complains.

import { mkdir, writeFile } from 'node:fs/promises'
import { violations } from './axe.mjs'
import { openContext, startActing, startBrowser, startDemo, startPlant } from './setup.mjs'

const folder = process.argv[2]
if (!folder) throw new Error('expected the folder for the pictures')

const DESK = { viewport: { width: 1280, height: 800 } }
const PHONE = { viewport: { width: 360, height: 740 }, hasTouch: true, isMobile: true }

/** How a page is seen. */
const LOOKS = {
  'desk-light': { ...DESK, colorScheme: 'light' },
  'desk-dark': { ...DESK, colorScheme: 'dark' },
  'phone-light': { ...PHONE, colorScheme: 'light' },
  'phone-dark': { ...PHONE, colorScheme: 'dark' },
}

/** The height at which a long page is cut. */
const LONGEST = 2400

/** The pages that change with the plant. */
const LIVE = ['/', '/plant', '/wall', '/trends', '/bus', '/alarms', '/events']

const STEADY = ['/gauge/chamber', '/rise?s=vessel&litres=12', '/audit', '/gateways']

/** The demonstration goes at this part of its speed: its shortest act has to last for all pictures of it. */
const SLOWED = 0.1

const LAST_ACT = 'All gauges measure again'

const defects = []
const taken = []

/** What is loaded after the page itself. */
async function settled(page) {
  await page.waitForLoadState('networkidle', { timeout: 2_000 }).catch(() => {})
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))))
}

/** Takes a page as it is. */
async function take(page, scene, look, name) {
  await settled(page)
  const [width, height, overflow] = await page.evaluate(() => {
    const { clientWidth, scrollWidth, scrollHeight } = document.documentElement
    return [clientWidth, scrollHeight, scrollWidth - clientWidth]
  })
  if (overflow > 0) defects.push(`${scene} ${name} ${look}: ${overflow} pixels too wide`)
  const file = `${scene}-${name.replace(/\W+/g, '-').replace(/^-|-$/g, '') || 'overview'}-${look}.png`
  const clip = { x: 0, y: 0, width, height: Math.min(height, LONGEST) }
  await page.screenshot({ path: `${folder}/${file}`, fullPage: true, clip })
  taken.push({ scene, name, look, file })
}

/** Takes pages of a station in every look; `ready` waits until a page is as it should be. */
async function takeAll(browser, station, scene, paths, { ready = isLive, more = {} } = {}) {
  for (const [look, options] of Object.entries(LOOKS)) {
    const { page, complaints, close } = await openContext(browser, { ...options, ...more })
    for (const path of paths) {
      await page.goto(station.url + path)
      await ready(page)
      await take(page, scene, look, path)
    }
    for (const found of await violations(page)) defects.push(`${scene} ${look}: ${found}`)
    for (const complaint of complaints) defects.push(`${scene} ${look}: ${complaint}`)
    await close()
  }
}

const isLive = (page) => page.locator('header .connection.good, .wall').first().waitFor()

const isLoginForm = (page) => page.getByLabel('Name').waitFor()

async function loggedIn(page) {
  await page.locator('form, header .connection.good').first().waitFor()
  if ((await page.getByLabel('Password', { exact: true }).count()) > 0) {
    await page.getByLabel('Name').fill('Erna')
    await page.getByLabel('Password', { exact: true }).fill('tin whisker plateau')
    await page.getByRole('button', { name: 'Log in' }).click()
  }
  await isLive(page)
}

async function identified(page) {
  await page.getByRole('spinbutton', { name: 'Volume L' }).fill('50')
  await page.getByRole('button', { name: 'Identify' }).click()
  await page.getByRole('heading', { name: 'What would help most' }).waitFor()
}

async function plantScenes(browser) {
  const hall = await startPlant()
  await takeAll(browser, hall, 'hall', [...LIVE, ...STEADY])
  await takeAll(browser, hall, 'hall-german', [...LIVE, ...STEADY], { more: { locale: 'de-DE' } })
  await hall.stop()
  const large = await startPlant('127.0.0.1:0', 'large')
  await takeAll(browser, large, 'large', [...LIVE, ...STEADY])
  await large.stop()
  const pumped = await startPlant('127.0.0.1:0', 'pumped')
  await takeAll(browser, pumped, 'pumped', ['/trends/pump-downs?series=transfer%20lock'])
  await takeAll(browser, pumped, 'identified', ['/rise/identify?series=test%20chamber'], { ready: identified })
  await pumped.stop()
  const acting = await startActing()
  await takeAll(browser, acting, 'login', ['/'], { ready: isLoginForm })
  await takeAll(browser, acting, 'acting', ['/gauge/chamber', '/audit'], { ready: loggedIn })
  await acting.stop()
}

/** The pages at each sentence that the demonstration tells, until its last one. */
async function demoScenes(browser) {
  const demo = await startDemo('--speed', String(SLOWED))
  const { page, close } = await openContext(browser)
  await page.goto(`${demo.url}/plant`)
  const latest = page.locator('.story-latest [lang="en"]')
  await latest.waitFor()
  for (let act = 1, text = ''; !text.startsWith(LAST_ACT); act += 1) {
    await page.waitForFunction(
      ([element, before]) => element.innerText !== before,
      [await latest.elementHandle(), text],
      { timeout: 0 },
    )
    text = await latest.innerText()
    await takeAll(browser, demo, `act-${String(act).padStart(2, '0')}`, LIVE)
  }
  await close()
  await demo.stop()
}

/** A page with all pictures: a section for each scene, a row for each page, a column for each look. */
function index() {
  const scenes = [...new Set(taken.map(({ scene }) => scene))]
  const row = (scene, name) => {
    const cells = taken.filter((one) => one.scene === scene && one.name === name)
    return `<tr><th>${name}</th>${cells.map(({ file }) => `<td><a href="${file}"><img src="${file}" loading="lazy"></a></td>`).join('')}</tr>`
  }
  const section = (scene) => {
    const names = [...new Set(taken.filter((one) => one.scene === scene).map(({ name }) => name))]
    return `<h2 id="${scene}">${scene}</h2><table>${names.map((name) => row(scene, name)).join('')}</table>`
  }
  return `<!doctype html><meta charset="utf-8"><title>Pages of the dashboard</title>
<style>body{font:14px system-ui}td,th{vertical-align:top;padding:4px}img{width:320px;border:1px solid #888}</style>
${scenes.map(section).join('\n')}`
}

await mkdir(folder, { recursive: true })
const only = process.argv[3]
if (![undefined, 'acts', 'plants'].includes(only)) throw new Error(`expected acts or plants, found ${only}`)
const browser = await startBrowser()
if (only !== 'acts') await plantScenes(browser)
if (only !== 'plants') await demoScenes(browser)
await browser.close()
await writeFile(`${folder}/index.html`, index())
console.log(`${taken.length} pictures in ${folder}, ${defects.length} defects`)
for (const defect of defects) console.log(defect)
process.exitCode = defects.length > 0 ? 1 : 0
