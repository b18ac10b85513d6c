// Takes pictures of every page, on a desk and on a phone, light and dark: at each act of the demonstration, of a plant with 15 gauges and
// of one with 480; then of details: zones, a drawing of one's own, dialogs, a lost station: `node gallery.mjs FOLDER [acts | plants | details]`.
// FOLDER/index.html shows them beside each other. Ends with 1 if a page can be scrolled sideways or complains, or if axe finds something.

import { mkdir, writeFile } from 'node:fs/promises'
import { detailScenes } from './gallery-details.mjs'
import { Gallery, loggedIn } from './gallery-pictures.mjs'
import { openContext, startActing, startBrowser, startDemo, startPlant } from './setup.mjs'

const folder = process.argv[2]
if (!folder) throw new Error('expected the folder for the pictures')

/** The pages that change with the plant. */
const LIVE = ['/', '/plant', '/wall', '/trends', '/bus', '/alarms', '/events']

const STEADY = ['/gauge/chamber', '/rise?s=vessel&litres=12', '/audit', '/gateways']

/** The demonstration goes at this part of its speed: its shortest act has to last for all pictures of it. */
const SLOWED = 0.07

const LAST_ACT = 'All gauges measure again'

const isLoginForm = (page) => page.getByLabel('Name').waitFor()

async function identified(page) {
  await page.getByRole('spinbutton', { name: 'Volume L' }).fill('50')
  await page.getByRole('button', { name: 'Identify' }).click()
  await page.getByRole('heading', { name: 'What would help most' }).waitFor()
}

async function plantScenes(gallery) {
  const hall = await startPlant()
  await gallery.takeAll(hall, 'hall', [...LIVE, ...STEADY])
  await gallery.takeAll(hall, 'hall-german', [...LIVE, ...STEADY], { more: { locale: 'de-DE' } })
  await hall.stop()
  const large = await startPlant('127.0.0.1:0', 'large')
  await gallery.takeAll(large, 'large', [...LIVE, ...STEADY])
  await large.stop()
  const pumped = await startPlant('127.0.0.1:0', 'pumped')
  await gallery.takeAll(pumped, 'pumped', ['/trends/pump-downs?series=transfer%20lock'])
  await gallery.takeAll(pumped, 'identified', ['/rise/identify?series=test%20chamber'], { ready: identified })
  await pumped.stop()
  const acting = await startActing()
  await gallery.takeAll(acting, 'login', ['/'], { ready: isLoginForm })
  await gallery.takeAll(acting, 'acting', ['/gauge/chamber', '/audit'], { ready: loggedIn })
  await acting.stop()
}

/** The pages at each sentence that the demonstration tells, until its last one. */
async function demoScenes(gallery) {
  const demo = await startDemo('--speed', String(SLOWED))
  const { page, close } = await openContext(gallery.browser)
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
    await gallery.takeAll(demo, `act-${String(act).padStart(2, '0')}`, LIVE)
  }
  await close()
  await demo.stop()
}

/** A page with all pictures: a section for each scene, a row for each page, a column for each look. */
function index({ taken }) {
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

const PARTS = { plants: plantScenes, details: detailScenes, acts: demoScenes }

await mkdir(folder, { recursive: true })
const only = process.argv[3]
if (only !== undefined && !(only in PARTS)) throw new Error(`expected acts, plants or details, found ${only}`)
const browser = await startBrowser()
const gallery = new Gallery(browser, folder)
for (const scenes of only === undefined ? Object.values(PARTS) : [PARTS[only]]) await scenes(gallery)
await browser.close()
const { taken, defects } = gallery
await writeFile(`${folder}/index.html`, index(gallery))
console.log(`${taken.length} pictures in ${folder}, ${defects.length} defects`)
for (const defect of defects) console.log(defect)
process.exitCode = defects.length > 0 ? 1 : 0
