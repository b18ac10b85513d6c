// Takes the pictures of docs/dashboard.md: `node pictures.mjs FOLDER`.

import { drawn, openContext, startActing, startBrowser, startDemo, startPlant } from './setup.mjs'

const folder = process.argv[2]
if (!folder) throw new Error('expected the folder for the pictures')

const LIGHT = { colorScheme: 'light' }
const DARK = { colorScheme: 'dark' }
const PHONE = { viewport: { width: 360, height: 740 }, hasTouch: true, isMobile: true }

/** The height at which a long page is cut. */
const LONGEST = 1400

const sparks = (page) => page.waitForFunction(() => document.querySelectorAll('.sparkline polyline').length >= 10)

/** Puts the cursor into the chart. */
async function point(page) {
  await drawn(page)
  const box = await page.locator('.chart .u-over').boundingBox()
  await page.mouse.move(box.x + box.width * 0.62, box.y + box.height * 0.4)
}

async function press(page) {
  await page.getByRole('button', { name: /^9: / }).click()
}

async function read(page) {
  await page.locator('.parameters').first().waitFor()
}

async function riseMarked(page) {
  await page.locator('.result').waitFor()
  await drawn(page)
}

async function alarmList(page) {
  await page.locator('.alarm-item').first().waitFor()
  await page.locator('.alarm-history tbody tr').first().waitFor()
}

/** The whole page, or the top of a long one. */
async function pageClip(page) {
  await page.evaluate(() => scrollTo(0, 0))
  const [width, height] = await page.evaluate(() => [
    document.documentElement.clientWidth,
    document.documentElement.scrollHeight,
  ])
  return { x: 0, y: 0, width, height: Math.min(height, LONGEST) }
}

const day = 'range=1d&s=chamber&s=load+lock&s=cryostat&s=gate+1&s=pump+stand.2&s=detector'

function pictures(start) {
  const rise = `/rise?s=vessel&begin=${start - 600_000}&end=${start}&litres=12`
  return [
    ['overview', '/', LIGHT, sparks],
    ['overview-dark', '/', DARK, sparks],
    ['overview-phone', '/', { ...LIGHT, ...PHONE }, sparks],
    ['german', '/alarms', { ...LIGHT, locale: 'de-DE' }, alarmList],
    ['trends', '/trends?range=1h&s=chamber&s=load+lock&s=gate+1&s=gate+2&s=pump+stand.2', LIGHT, point],
    ['trends-dark', `/trends?${day}&whole`, DARK, point],
    ['trends-phone', '/trends?range=1h&s=chamber&s=gate+1', { ...DARK, ...PHONE }, drawn],
    ['bus', '/bus', LIGHT, press],
    ['gauge', '/gauge/chamber', LIGHT, read],
    ['rise', rise, LIGHT, riseMarked],
    ['alarms', '/alarms', LIGHT, alarmList],
    ['alarms-dark', '/alarms', DARK, alarmList],
    ['alarms-phone', '/alarms', { ...DARK, ...PHONE }, alarmList],
    ['events', '/events', LIGHT, (page) => page.locator('.events tbody tr').first().waitFor()],
  ]
}

/** Arms a degas. */
async function armed(page) {
  await page.locator('.control', { hasText: 'You have control' }).waitFor()
  await page.locator('[data-command="ba.degas-on"] button').click()
  await page.getByRole('button', { name: 'Send' }).waitFor()
}

/** Ends the degas of the picture before, and arms another one. */
async function armedAgain(page) {
  await page.locator('.control', { hasText: 'You have control' }).waitFor()
  await page.locator('[data-command="ba.degas-off"] button').click()
  await page.getByRole('button', { name: 'Send' }).click()
  await page.getByText('Done: ').waitFor()
  await page.getByRole('dialog').getByRole('button', { name: 'Close' }).click()
  await armed(page)
}

/** Sends a degas, and shows the audit trail. */
async function sent(page) {
  await page.locator('.commands').getByRole('button', { name: 'Request control' }).click()
  await armed(page)
  await page.getByRole('button', { name: 'Send' }).click()
  await page.getByText('Done: ').waitFor()
  await page.goto(new URL('/audit', page.url()).href)
  await page.locator('.audit [data-kind="outcome"]').waitFor()
}

const ACTING = [
  ['audit', '/gauge/chamber', LIGHT, sent],
  ['command', '/gauge/chamber', LIGHT, armedAgain],
]

/** Enters the volume and waits for the numbers of the plant. */
async function identified(page) {
  await page.getByRole('spinbutton', { name: 'Volume L' }).fill('50')
  await page.getByRole('button', { name: 'Identify' }).click()
  await page.getByRole('heading', { name: 'What would help most' }).waitFor()
}

const PUMPED = [
  ['identify', '/rise/identify?series=test%20chamber', LIGHT, identified],
  [
    'pump-downs',
    '/trends/pump-downs?series=transfer%20lock',
    LIGHT,
    (page) => page.locator('svg polyline.shown').waitFor(),
  ],
]

/** Waits for the leak of the demonstration and its alarm. */
async function leaking(page) {
  await page.locator('[data-part="flange"] .state', { hasText: 'leaks' }).waitFor()
  await page.locator('[data-volume="chamber"] .words').waitFor()
}

const DEMO = [
  ['plant', '/plant', LIGHT, leaking],
  ['plant-dark', '/plant', DARK, leaking],
  ['plant-phone', '/plant', { ...LIGHT, ...PHONE }, leaking],
]

const browser = await startBrowser()

async function login(page, user) {
  await page.getByLabel('Name').fill(user)
  await page.getByLabel('Password', { exact: true }).fill('tin whisker plateau')
  await page.getByRole('button', { name: 'Log in' }).click()
}

/** Takes pictures of a station; as a user if one is given. */
async function take(plant, all, user = null) {
  for (const [name, path, options, ready] of all) {
    const { page, complaints, close } = await openContext(browser, options)
    await page.goto(plant.url + path)
    if (user) await login(page, user)
    await page.locator('header .connection.good').waitFor()
    await ready(page)
    if (complaints.length) throw new Error(`${name}: ${complaints.join('; ')}`)
    const clip = name === 'command' ? undefined : await pageClip(page)
    await page.screenshot({
      path: `${folder}/dashboard-${name}.png`,
      fullPage: clip !== undefined,
      ...(clip ? { clip } : {}),
    })
    await close()
  }
  await plant.stop()
}

const plant = await startPlant()
const { started_ms } = await plant.json('/api/station')
await take(plant, pictures(started_ms))
await take(await startPlant('127.0.0.1:0', 'pumped'), PUMPED)
await take(await startActing(), ACTING, 'Erna')
await take(await startDemo(), DEMO)
await browser.close()
