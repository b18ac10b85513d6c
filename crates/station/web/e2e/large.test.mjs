// The dashboard of a plant with 480 gauges.

import assert from 'node:assert/strict'
import { after, before, test } from 'node:test'
import { becomes, openContext, openPage, startBrowser, startPlant } from './setup.mjs'

let browser
let plant

before(async () => {
  ;[browser, plant] = await Promise.all([startBrowser(), startPlant('127.0.0.1:0', 'large')])
})

after(async () => {
  await browser?.close()
  await plant?.stop()
})

async function visit(path, look, options = {}) {
  const { page, complaints, close } = await openPage(browser, plant.url + path, options)
  try {
    await look(page)
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
}

test('480 gauges are listed by segment, and the problems come first', async () => {
  assert.equal((await plant.json('/api/gauges')).length, 480)
  await visit('/', async (page) => {
    const problems = page.getByRole('region', { name: 'Problems' })
    await problems.waitFor()
    const names = await problems.locator('.row').evaluateAll((rows) => rows.map(({ dataset }) => dataset.gauge))
    // Alarms first, the highest priority at the top.
    assert.equal(names[0], 'gate 2')
    for (const name of ['cryostat', 's05-35', 's11-31', 'oven', 'spare'])
      assert.ok(names.includes(name), `${name}: ${names}`)
    const height = await page.evaluate(() => document.documentElement.scrollHeight)
    assert.ok(height < 2_000, `${height} pixels`)
    const ends = await problems.locator('.row').evaluateAll((rows) =>
      rows.map((row) => {
        const [whole, readings] = [row, row.querySelector('.row-readings')].map((one) => one.getBoundingClientRect())
        return whole.right - readings.right
      }),
    )
    assert.equal(new Set(ends.map(Math.round)).size, 1, `pressures end at ${ends} pixels from the end of their rows`)
    assert.match(
      await problems.locator('[data-gauge="cryostat"]').innerText(),
      /ionisation part: electronics or sensor/,
    )
    const beamLine = page.getByRole('region', { name: 'Segment beam line' })
    const closed = await beamLine.locator('summary').innerText()
    assert.match(closed, /6 gauges, 2 of them under Problems\s+2\.\d+ × 10⁻⁹ mbar to > 1000 mbar$/)
    const segment = page.getByRole('region', { name: 'Segment segment 04' })
    await becomes(() => segment.locator('.row').count(), 0)
    await segment.locator('summary').click()
    await segment.locator('.row').first().waitFor()
    await becomes(() => segment.locator('.row').count(), 34)
  })
})

test('the bus map of 480 gauges is short, and its problems are at the top', async () => {
  await visit('/bus', async (page) => {
    const segments = page.locator('.segment-map')
    await segments.first().waitFor()
    const names = await segments.evaluateAll((all) => all.map(({ dataset }) => dataset.segment))
    assert.deepEqual(names.slice(0, 5), ['bench', 'hall', 'segment 05', 'segment 11', 'beam line'])
    await becomes(() => page.locator('button.cell').count(), 480 + names.length + 2)
    await becomes(() => page.locator('.cell.empty').count(), 0)
    const height = await page.evaluate(() => document.documentElement.scrollHeight)
    assert.ok(height < 2_700, `${height} pixels`)
  })
})

test('notifications that are not delivered are named above the problems, with the way to the alarms', async () => {
  const webhook = { kind: 'email', problem: 'refused', failing_since_ms: 1, at: 'smtp://x', waiting: 3 }
  const { page, complaints, close } = await openContext(browser)
  try {
    await page.route('**/api/webhooks', (route) => route.fulfill({ json: [{ name: 'shift', ...webhook }] }))
    await page.goto(plant.url)
    await page.getByRole('link', { name: 'Notifications of alarms are not delivered: shift', exact: true }).click()
    await page.waitForURL('**/alarms')
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
})

test('the alarm of a segment stands above the problems, and the wall names the problems that are not on every page', async () => {
  await visit('/', async (page) => {
    const others = page.getByRole('list', { name: 'Alarms without a gauge' }).getByRole('listitem')
    await others.first().waitFor()
    assert.match(
      await others.first().innerText(),
      /^1\s+high segment bench: down segment bench is not running or gives no data$/,
    )
    await becomes(() => others.count(), 1)
  })
  const { page, complaints, close } = await openContext(browser, { viewport: { width: 1100, height: 640 } })
  try {
    await page.goto(`${plant.url}/wall`)
    await page
      .locator('.wall-turning', { hasText: '4 problems are not on every page: spare, oven, s05-35, s11-31' })
      .waitFor()
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
})

test('a search finds a gauge among 480 by its name, segment or device', async () => {
  await visit('/', async (page) => {
    await page.getByLabel('Search gauges').fill('s09-12')
    await page.locator('.row[data-gauge="s09-12"]').waitFor()
    await becomes(() => page.locator('.row').count(), 1)
    await page.getByRole('status').getByText('1 of 480 gauges').waitFor()
    await page.getByLabel('Search gauges').fill('segment 09 s09')
    await page.getByRole('status').getByText('34 of 480 gauges').waitFor()
    await page.getByLabel('Search gauges').fill('nothing like that')
    await page.getByText('No gauge matches nothing like that.').waitFor()
  })
})

test('the series of a large plant are searched, and those that are drawn stay in the list', async () => {
  await visit('/trends?s=s07-20', async (page) => {
    const names = page.locator('.series-list .name')
    await names.first().waitFor()
    assert.ok((await names.count()) < 40, 'the list is short')
    await page.getByText(/more series: search to see them/).waitFor()
    await page.getByLabel('Search series').fill('s16')
    await names.getByText('s16-03', { exact: true }).waitFor()
    await page.locator('.series-list li', { hasText: 's16-03' }).getByRole('checkbox').check()
    await page.waitForURL(/s=s07-20&s=s16-03/)
    assert.deepEqual((await names.allInnerTexts()).slice(0, 2), ['s07-20', 's16-03'])
  })
})

test('pressures of a large plant change as they arrive', async () => {
  await visit('/', async (page) => {
    await page.getByLabel('Search gauges').fill('s09-12')
    const pressure = await page.locator('.row [data-series="s09-12"]').elementHandle()
    const first = await pressure.innerText()
    await page.waitForFunction(([element, first]) => element.innerText !== first, [pressure, first])
  })
})

test('a filter by group, tag, location and state is in the address and survives a reload', async () => {
  await visit('/', async (page) => {
    const said = (text) => page.getByRole('status').getByText(text).waitFor()
    await page.getByLabel('Group').selectOption('ring, inside')
    await page.waitForURL(/group=ring%2C\+inside/)
    await said('229 of 480 gauges')
    await page.getByLabel('Location').selectOption('segment 04')
    await said('34 of 480 gauges')
    await page.getByLabel('Tag').selectOption('bake-out')
    await said('12 of 480 gauges')
    await page.reload()
    await said('12 of 480 gauges')
    await becomes(() => page.getByLabel('Location').inputValue(), 'segment 04')
    await becomes(() => page.locator('.row').count(), 12)
    await page.getByLabel('State').selectOption('problems')
    await page.getByText('No gauge passes the filter.').waitFor()
  })
  await visit('/?state=fault&group=ring,+outside', async (page) => {
    await page.getByRole('status').getByText('1 of 480 gauges').waitFor()
    await page.locator('.row[data-gauge="s05-35"]').waitFor()
  })
})

test('an overdue calibration is said in words, is no problem, and can be filtered', async () => {
  await visit('/?state=calibration-overdue', async (page) => {
    await page.getByRole('status').getByText('1 of 480 gauges').waitFor()
    const row = page.locator('.row[data-gauge="oven"]')
    await row.getByText('calibration overdue, was valid until 2021-03-01').waitFor()
  })
  await visit('/gauge/oven', async (page) => {
    const labels = page.locator('.gauge-labels')
    await labels.getByText('2020-03-01, valid until 2021-03-01').waitFor()
    await labels.getByText('calibration overdue').waitFor()
    await labels.getByRole('link', { name: 'laboratory' }).click()
    await page.waitForURL(/\/\?group=laboratory/)
    await page.getByRole('status').getByText('1 of 480 gauges').waitFor()
  })
  await visit('/gauge/cryostat', async (page) => {
    await page.locator('.gauge-labels').getByText('valid until 2121-03-01').waitFor()
    await becomes(() => page.getByText('calibration overdue').count(), 0)
  })
})
