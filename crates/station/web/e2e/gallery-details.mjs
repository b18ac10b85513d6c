// The scenes of the gallery that need more than an address: zones, a drawing of one's own, dialogs, a station that has stopped.

import { mkdtemp, rm, writeFile } from 'node:fs/promises'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { LOOKS, loggedIn } from './gallery-pictures.mjs'
import { drawn, openContext, startActing, startLastingDemo, startPlant } from './setup.mjs'
import { startZones } from './zones.mjs'

export async function detailScenes(gallery) {
  await zoneScenes(gallery)
  await dialogScenes(gallery)
  await lostScene(gallery)
}

const PLANT_PAGES = ['/plant', '/', '/wall']

async function zoneScenes(gallery) {
  const zones = await startZones()
  await gallery.takeAll(zones, 'zones', [...PLANT_PAGES, '/alarms'], { ready: judged })
  await zones.stop()
  const own = await startZones({ isDrawn: true })
  await gallery.takeAll(own, 'own-drawing', PLANT_PAGES, { ready: judged })
  await own.stop()
}

/** The gauges measure, and the alarm of the target is raised. */
async function judged(page) {
  await page.locator('[data-alarm="high"], .priority.high, .alarm-shape.high, [data-priority="high"]').first().waitFor()
  const picture = page.locator('.plant-picture [data-volume], .own-drawing [data-volume]')
  if (!page.url().endsWith('/wall') && !page.url().endsWith('/alarms')) await picture.first().waitFor()
}

const dialog = (page) => page.getByRole('dialog')
const active = (page, name) => page.getByRole('region', { name: 'Active alarms' }).locator(`[data-alarm="${name}"]`)

/** Opens the panel that a heading closes. */
async function opened(page, name) {
  const panel = page.getByRole('region', { name })
  await panel.locator('summary').first().click()
  return panel
}

async function alarmSettings(page) {
  const all = await opened(page, 'All alarms')
  await all.getByRole('searchbox').fill('gate 2')
  await all.getByRole('button', { name: 'Settings: gate 2 not evacuated' }).click()
  await dialog(page).getByLabel('Above').waitFor()
}

async function defaultAlarmSettings(page) {
  const panel = page.getByRole('region', { name: 'Default alarms' })
  if (!(await panel.getByRole('button').first().isVisible())) await panel.locator('summary').first().click()
  await panel.getByRole('button').first().click()
  await dialog(page).getByLabel('Reason').waitFor()
}

async function shelving(page) {
  await active(page, 'gate 2 not evacuated').locator('button.name').click()
  await active(page, 'gate 2 not evacuated')
    .getByRole('button', { name: /^Shelve/ })
    .click()
  await dialog(page).getByLabel('Reason').fill('The gate is being repaired.')
}

async function outOfService(page) {
  const gate = active(page, 'gate 2 not evacuated')
  await gate.getByRole('button', { name: /^Out of service/ }).click()
  await dialog(page).getByLabel('Reason').waitFor()
}

async function declaring(page) {
  await page.getByRole('button', { name: 'Declare: Vented' }).click()
  await dialog(page).getByLabel('Reason').fill('The target is changed.')
}

async function performance(page) {
  const panel = await opened(page, 'Alarm performance')
  await panel.getByRole('table', { name: 'Alarm performance' }).waitFor()
  return panel
}

async function notifications(page) {
  const panel = page.getByRole('region', { name: 'Notifications' })
  await panel.getByText('failing since').waitFor()
  return panel
}

async function backup(page) {
  await page.getByRole('button', { name: 'Copy the database' }).click()
  await dialog(page).getByRole('button', { name: 'Make the copy' }).waitFor()
}

async function backupMade(page) {
  await backup(page)
  await dialog(page).getByRole('button', { name: 'Make the copy' }).click()
  await dialog(page).getByRole('link', { name: 'Download the copy' }).waitFor()
}

/** A reference in the first part of the chart, and the cursor in the last. */
async function compared(page) {
  await drawn(page)
  const over = await page.locator('.chart .u-over').boundingBox()
  const at = (part) => [over.x + over.width * part, over.y + over.height / 2]
  await page.mouse.click(...at(0.2))
  await page.getByText(/^Reference \d{4}-/).waitFor()
  await page.mouse.move(...at(0.85))
  await page.locator('.cursor-time strong', { hasText: ':' }).waitFor()
  await page.locator('.difference').first().waitFor()
}

/** The same in a window that has room for the whole page: the mouse would leave the chart when the window changes for the picture. */
async function wholeCompared(page) {
  const { width } = page.viewportSize()
  await page.setViewportSize({ width, height: 1800 })
  await compared(page)
}

async function note(page) {
  await compared(page)
  await page.getByRole('button', { name: 'Make a note' }).click()
  await dialog(page).getByLabel('Text').fill('The trap is filled.')
}

async function armed(page) {
  const request = page.locator('.commands').getByRole('button', { name: 'Request control' })
  const mine = page.locator('.control', { hasText: 'You have control' })
  await request.or(mine).first().waitFor()
  if (await request.isVisible()) await request.click()
  await mine.first().waitFor()
  await page.locator('[data-command="ba.degas-on"] button').click()
  await page.getByRole('button', { name: 'Send' }).waitFor()
}

/** Shows the choices of the head, which a phone hides. */
async function openMenu(page) {
  const menu = page.getByRole('button', { name: 'Control, unit, language and theme' })
  if (await menu.isVisible()) await menu.click()
}

async function refused(page) {
  await openMenu(page)
  await page.getByRole('button', { name: /^Erna/ }).click()
  await dialog(page).getByLabel('Current password', { exact: true }).fill('tin whisker plateau')
  await dialog(page).getByLabel('New password', { exact: true }).fill('password1')
  await dialog(page).getByRole('button', { name: 'Change password' }).click()
  await dialog(page).getByRole('alert').waitFor()
}

async function help(page) {
  await openMenu(page)
  await page.getByRole('button', { name: 'Help' }).click()
  await dialog(page).waitFor()
}

async function settingsCompared(page) {
  await page.getByLabel('Compare settings with').selectOption('pcg550 5')
  const comparison = page.getByRole('region', { name: 'Settings beside those of pcg550 5' })
  await comparison.getByText(/settings differ\.$/).waitFor()
  return comparison
}

async function takenOver(page) {
  const request = page.locator('.commands').getByRole('button', { name: 'Request control' })
  if (await request.isVisible()) await request.click()
  await settingsCompared(page)
  await page.locator('[data-difference]').first().getByRole('button').click()
  await dialog(page).getByRole('button', { name: 'Send' }).waitFor()
}

/** What is shown of a page: its name, its path, what opens it. Of a long page only the panel that was opened is taken. */
const ALARM_DIALOGS = [
  ['alarm settings', '/alarms', alarmSettings],
  ['default alarm settings', '/alarms', defaultAlarmSettings],
  ['shelving', '/alarms', shelving],
  ['out of service', '/alarms', outOfService],
  ['plant state', '/alarms', declaring],
  ['alarm performance', '/alarms', performance],
  ['notifications', '/alarms', notifications],
  ['backup', '/audit', backup],
  ['backup made', '/audit', backupMade],
  ['help', '/', help],
]

const COMPARED = '/trends?range=1h&s=chamber&s=load+lock&s=gate+2&s=vessel'

const TREND_DIALOGS = [
  ['note', COMPARED, note],
  ['differences', COMPARED, wholeCompared],
]

const ACTING_DIALOGS = [
  ['command', '/gauge/chamber', armed],
  ['password', '/', refused],
]

const COMPARISONS = [
  ['settings compared', '/gauge/pcg550%206', settingsCompared],
  ['setting taken over', '/gauge/pcg550%206', takenOver],
]

/** Two gauges of a model, and one of another. */
const SCENARIO = `title = "Two gauges of a model"
seed = 1
until = "1 h"

[volumes]
chamber = { volume = "20 l", pressure = "1e-2 mbar" }

[gauges]
"pcg550@5" = "chamber"
"pcg550@6" = "chamber"
"bcg450@7" = "chamber"
`

async function dialogScenes(gallery) {
  const plant = await startPlant('127.0.0.1:0', 'users')
  await takeOpened(gallery, plant, [...ALARM_DIALOGS, ...TREND_DIALOGS], (page) => loggedIn(page, 'ada'))
  await plant.stop()
  const acting = await startActing()
  await takeOpened(gallery, acting, ACTING_DIALOGS, loggedIn)
  await acting.stop()
  const folder = await mkdtemp(join(tmpdir(), 'profivac-gallery-'))
  const file = join(folder, 'two.toml')
  await writeFile(file, SCENARIO)
  const two = await startLastingDemo('--scenario', file)
  await makeDifferent(gallery, two)
  await takeOpened(gallery, two, COMPARISONS, (page) => page.locator('header .connection.good').waitFor())
  await two.stop()
  await rm(folder, { recursive: true, force: true })
}

/** Changes a setting of one gauge. */
async function makeDifferent(gallery, station) {
  const { page, close } = await openContext(gallery.browser)
  await page.goto(`${station.url}/gauge/pcg550%205`)
  await page.locator('header').getByRole('button', { name: 'Request control' }).click()
  const row = page.locator('[data-target="pirani.safe-state"]')
  await row.getByRole('button', { name: 'Change Safe State' }).click()
  await row.getByRole('combobox').selectOption('hold-last-value')
  await row.getByRole('button', { name: 'Arm' }).click()
  await dialog(page).getByRole('button', { name: 'Send' }).click()
  await dialog(page)
    .getByText(/was .* and reads/)
    .first()
    .waitFor()
  await page.keyboard.press('Escape')
  await page.locator('header').getByRole('button', { name: 'Release' }).click()
  await close()
}

/** Chromium reports a refused request, such as that of a weak password, as an error on the console. */
const REFUSAL = /status of 400/

/** Takes what `scenes` open, in every look; `ready` waits for the page, and logs in where it asks for it. */
async function takeOpened(gallery, station, scenes, ready) {
  for (const [look, options] of Object.entries(LOOKS)) {
    const takeEach = async (page) => {
      for (const [name, path, open] of scenes) {
        await page.goto(station.url + path)
        await ready(page)
        // The other pictures are worth having without this one.
        const panel = await open(page).catch((problem) => {
          gallery.defects.push(`dialogs ${name} ${look}: ${String(problem).split('\n')[0]}`)
        })
        await gallery.take(page, 'dialogs', look, name, { whole: (await dialog(page).count()) === 0, panel })
      }
    }
    await gallery.open('dialogs', look, options, takeEach, REFUSAL)
  }
}

/** Every page is open before its station stops. */
async function lostScene(gallery) {
  const [zones, hall] = await Promise.all([startZones(), startPlant()])
  const pages = []
  for (const [look, options] of Object.entries(LOOKS)) {
    for (const [station, path] of [...PLANT_PAGES.map((path) => [zones, path]), [hall, COMPARED]]) {
      const { page, close } = await openContext(gallery.browser, options)
      await page.goto(station.url + path)
      await (station === zones ? judged(page) : drawn(page))
      pages.push({ look, path, page, close })
    }
  }
  await Promise.all([zones.stop(), hall.stop()])
  for (const { look, path, page, close } of pages) {
    await page.locator('header .connection.lost, .wall [role="alert"]').first().waitFor()
    await page.locator('.stale, [data-quality="stale"], .chart').first().waitFor()
    await gallery.take(page, 'lost', look, path)
    await close()
  }
}
