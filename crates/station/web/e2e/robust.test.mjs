// What must not stop an operator: many alarms, many page loads, a browser without a language, a slow station, a fault in a page.

import assert from 'node:assert/strict'
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after, before, test } from 'node:test'
import { becomes, openContext, openPage, startBrowser, startGauges, startPlant, startStation } from './setup.mjs'

let browser
let plant

before(async () => {
  ;[browser, plant] = await Promise.all([startBrowser(), startPlant()])
})

after(async () => {
  await browser?.close()
  await plant?.stop()
})

test('a gauge shows its alarm however many more urgent ones there are', async (t) => {
  const folder = mkdtempSync(join(tmpdir(), 'flood-'))
  t.after(() => rmSync(folder, { recursive: true }))
  const gauges = await startGauges('--pressure', '1e-3 mbar', 'bcg450@5', 'pcg550@6')
  t.after(gauges.stop)
  const alarm = (name, gauge, priority) =>
    `[[alarm]]\nname = "${name}"\ngauge = "${gauge}"\nabove = "1e-9 mbar"\ndelay = "0 s"\npriority = "${priority}"\n`
  const many = Array.from({ length: 60 }, (_, number) => alarm(`chamber ${number}`, 'chamber', 'high'))
  const file = join(folder, 'plant.toml')
  writeFileSync(
    file,
    `[station]
database = "plant.db"
[[segment]]
name = "hall"
port = "${gauges.port}"
[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"
[[segment.gauge]]
name = "foreline"
address = 6
device = "pcg550"
${[...many, alarm('foreline is vented', 'foreline', 'low')].join('')}`,
  )
  const station = await startStation(file)
  t.after(station.stop)
  const { page, complaints, close } = await openPage(browser, station.url)
  await page.locator('[data-gauge="foreline"]').getByText('foreline is vented').first().waitFor()
  await page.goto(`${station.url}/wall`)
  await page.getByText('foreline is vented').first().waitFor()
  assert.deepEqual(complaints, [])
  await close()
})

test('pages that the browser keeps for its back button hold no connection', async () => {
  const keeping = await startBrowser({ ignoreDefaultArgs: ['--disable-back-forward-cache'] })
  try {
    const { page, close } = await openContext(keeping)
    // A browser opens six connections to a station.
    for (const path of ['/', '/alarms', '/events', '/bus', '/trends', '/plant', '/audit', '/']) {
      await page.goto(plant.url + path)
      await page.locator('header .connection.good').waitFor()
    }
    await page.goBack()
    await page.locator('header .connection.good').waitFor()
    await close()
  } finally {
    await keeping.close()
  }
})

test('a browser that calls its language "C" draws the pages', async () => {
  const { page, complaints, close } = await openContext(browser)
  await page.addInitScript(() => {
    for (const [name, value] of [
      ['language', 'C'],
      ['languages', ['C']],
    ])
      Object.defineProperty(Navigator.prototype, name, { get: () => value, configurable: true })
  })
  await page.goto(`${plant.url}/trends`)
  await page.locator('header .connection.good').waitFor()
  assert.deepEqual(complaints, [])
  await close()
})

test('a table says that it waits, and that it is empty only after the answer', async () => {
  const { page, close } = await openContext(browser)
  let answer = null
  await page.route('**/api/audit*', (route) => {
    answer = () => route.fulfill({ json: [] })
  })
  await page.goto(`${plant.url}/audit`)
  await page.getByText('Loading …').waitFor()
  await becomes(() => page.getByText('No entries').count(), 0)
  await answer()
  await page.getByText('No entries').waitFor()
  await becomes(() => page.getByText('Loading …').count(), 0)
  await close()
})

test('a table that could not be fetched says why and is fetched again, and no chart has an axis before its data', async () => {
  const { page, close } = await openContext(browser)
  let isBroken = true
  await page.route('**/api/audit*', (route) => (isBroken ? route.fulfill({ status: 500, json: {} }) : route.continue()))
  await page.goto(`${plant.url}/audit`)
  const again = page.getByRole('button', { name: 'Try again' })
  await again.waitFor()
  await becomes(
    () => page.locator('.query-state').evaluateAll((all) => all.map((one) => one.className)),
    ['error query-state failed'],
  )
  isBroken = false
  await again.click()
  await becomes(() => again.count(), 0)
  let answer = null
  await page.route('**/api/trend?*', (route) => {
    answer = () => route.continue()
  })
  await page.goto(`${plant.url}/rise`)
  await page.locator('.chart-place .query-state.loading').waitFor()
  await becomes(() => page.locator('.chart').count(), 0)
  await becomes(() => answer !== null, true)
  await page.unroute('**/api/trend?*')
  await answer()
  await page.locator('.chart').waitFor()
  await close()
})

test('a fault in a page becomes words below a header that works', async () => {
  const { page, close } = await openContext(browser)
  // No station answers so.
  await page.route('**/api/audit*', (route) => route.fulfill({ json: [null] }))
  await page.goto(`${plant.url}/audit`)
  await page.getByRole('alert').getByRole('button', { name: 'Load again' }).waitFor()
  await page.getByRole('link', { name: 'Overview' }).first().click()
  await page.locator('[data-gauge]').first().waitFor()
  await becomes(() => page.getByRole('button', { name: 'Load again' }).count(), 0)
  await close()
})

test('the title of a window counts the alarms that nobody has acknowledged', async () => {
  const waiting = (await plant.json('/api/alarms')).filter(({ state }) =>
    ['unacknowledged', 'returned'].includes(state),
  )
  assert.ok(waiting.length > 0)
  const { page, close } = await openPage(browser, plant.url)
  await becomes(() => page.title(), `(${waiting.length}) Overview · Target hall`)
  await close()
})

test('eight windows share one stream, and each of them reaches the station', async () => {
  const { page, complaints, close } = await openPage(browser, plant.url)
  const windows = [page]
  // A browser opens six connections to a station.
  for (const path of ['/alarms', '/events', '/bus', '/trends', '/plant', '/wall', '/audit']) {
    const window = await page.context().newPage()
    await window.goto(plant.url + path)
    windows.push(window)
  }
  for (const window of windows) {
    await window.locator('header .connection.good, .wall').waitFor()
    assert.equal(await window.evaluate(async () => (await fetch('/api/alarms')).status), 200)
  }
  // The window that came first is not needed for the others.
  await page.close()
  plant.tell('vessel=5e4')
  await windows[1].locator('[data-alarm="vessel vented"]').waitFor()
  plant.tell('vessel=1')
  assert.deepEqual(complaints, [])
  await close()
})

test('an action that the station has not answered yet is seen to wait', async () => {
  const { page, close } = await openPage(browser, `${plant.url}/alarms`)
  let answer = null
  await page.route('**/acknowledge', (route) => {
    answer = () => route.continue()
  })
  const button = page.locator('.alarm-item button.acknowledge').first()
  await button.click()
  await page.getByText('Waiting for the answer to your action').waitFor()
  await becomes(() => button.getAttribute('aria-busy'), 'true')
  await answer()
  await becomes(() => page.getByText('Waiting for the answer to your action').count(), 0)
  await becomes(() => page.locator('[aria-busy]').count(), 0)
  await close()
})
