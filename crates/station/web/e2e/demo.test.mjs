// The dashboard over the demo plant: all data pass the codec and the state machines of master and slaves.

import assert from 'node:assert/strict'
import { after, before, test } from 'node:test'
import { becomes, drawn, openPage, startBrowser, startDemo } from './setup.mjs'

let browser
let demo

before(async () => {
  ;[browser, demo] = await Promise.all([startBrowser(), startDemo('--speed', '3')])
})

after(async () => {
  await browser?.close()
  await demo?.stop()
})

async function visit(path, look) {
  const { page, complaints, close } = await openPage(browser, demo.url + path)
  try {
    await look(page)
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
}

test('all twelve devices show pressures, and the pressures change', async () => {
  await visit('/', async (page) => {
    await page.waitForFunction(() => document.querySelectorAll('[data-gauge] .big[data-series]').length >= 12)
    const chamber = page.locator('.big[data-series="bcg450 5"]')
    const first = await chamber.innerText()
    assert.match(first, / mbar$/)
    await page.waitForFunction(
      ([element, first]) => element.innerText !== first,
      [await chamber.elementHandle(), first],
    )
  })
})

test('the bus map shows the master and its slaves', async () => {
  const [segment] = await demo.json('/api/segments')
  assert.equal(segment.stations.length, 13)
  await visit('/bus', async (page) => {
    await page.getByText('our master', { exact: false }).first().waitFor()
  })
})

test('the parameters of a gauge are read over the bus', async () => {
  const blocks = await demo.json(`/api/gauges/${encodeURIComponent('bcg450 5')}/blocks`)
  const values = blocks.flatMap(({ parameters }) => parameters).filter(({ value }) => value !== null)
  assert.ok(values.length > 50, `${values.length} values`)
})

test('the page of a TPG has its channels, and its parameters through the parameter channel', async () => {
  await visit('/gauge/tpg300%2014', async (page) => {
    const filter = page.locator('[data-target="a1.filter-time-constant"]')
    await filter.waitFor()
    assert.match(await filter.innerText(), /medium/)
    await becomes(() => page.locator('[data-command="device.store"]').count(), 1)
    const details = await page.locator('.readings .reading-channel').allInnerTexts()
    assert.deepEqual(
      details.map((text) => text.slice(0, 'channel 1'.length)),
      ['channel 1', 'channel 2', 'channel 3', 'channel 4'],
    )
  })
})

test('the pump-down is drawn', async () => {
  await visit('/trends', drawn)
})

test('at first the plant state is Chamber pump-down, which suppresses the alarm of the chamber; the leak raises it, and it is acknowledged', async () => {
  const own = await startDemo('--speed', '3')
  const { page, complaints, close } = await openPage(browser, `${own.url}/alarms`)
  try {
    const chamber = page.locator('[data-alarm="chamber above 1e-3 mbar"]:not(.suppressed)')
    await chamber.getByRole('button', { name: 'Acknowledge' }).waitFor()
    assert.match(await chamber.innerText(), /Is a flange open/)
    await chamber.getByRole('button', { name: 'Acknowledge' }).click()
    await chamber.getByRole('button', { name: 'Acknowledge' }).waitFor({ state: 'detached' })
    const history = await own.json('/api/alarms/history?from=0&to=9999999999999&alarm=chamber+above+1e-3+mbar')
    const changes = history.map(({ change }) => change).reverse()
    assert.deepEqual(changes.slice(0, 3), ['suppressed', 'unsuppressed', 'raised'], 'the leak alone raises it')
    assert.ok(history.find(({ change }) => change === 'raised').value > 0.1, 'it is raised above its limit of 0.1 Pa')
    assert.equal(history.find(({ change }) => change === 'acknowledged').user, 'demo')
    await page.goto(`${own.url}/wall`)
    const controller = page.locator('[data-series="img400 16"]')
    await controller.locator('.wall-value', { hasText: 'fault' }).waitFor()
    assert.deepEqual(complaints, [])
  } finally {
    await close()
    await own.stop()
  }
})

test('a gauge below its range is under range and no fault, and an ion gauge without emission is off', async () => {
  await visit('/', async (page) => {
    const pirani = page.locator('[data-gauge="pcg550 8"]')
    await pirani.locator('.big', { hasText: '< 5.00 × 10⁻⁵ mbar' }).waitFor()
    assert.match(await pirani.innerText(), /under range/)
    await becomes(() => pirani.locator('.faults').count(), 0)
  })
  const gauges = await demo.json('/api/gauges')
  for (const { readings } of gauges) {
    for (const { pa, quality, series } of readings) {
      assert.equal(pa !== null, quality === 'valid', series)
      assert.notEqual(pa, 0, series)
    }
  }
})

/** Chromium reports a refused request as an error on the console. */
const REFUSAL = /the server responded with a status of 409/

/** Arms a degas again and again until the dialog shows what is expected: the pressure changes meanwhile. */
async function degas(page, wanted) {
  const dialog = page.getByRole('dialog', { name: 'Command' })
  for (;;) {
    await page.locator('[data-command="ba.degas-on"] button').click()
    const send = dialog.getByRole('button', { name: 'Send' })
    await send.or(dialog.locator('.error')).first().waitFor()
    if (await wanted(dialog, send)) return
    await dialog.getByRole('button', { name: /Close|Disarm/ }).click()
    await dialog.waitFor({ state: 'hidden' })
  }
}

test('a degas is refused while the pressure is too high and sent when it is low', async () => {
  const own = await startDemo()
  const { page, complaints, close } = await openPage(browser, `${own.url}/gauge/bcg450%205`)
  try {
    await page.locator('.control').getByRole('button', { name: 'Request control' }).click()
    await page.locator('.control', { hasText: 'You have control' }).waitFor()
    const unmet = (dialog) =>
      dialog.locator('.conditions .unmet', { hasText: 'ba.process-value is below 7.20 × 10⁻⁶ mbar' })
    await degas(page, async (dialog, send) => (await unmet(dialog).count()) === 1 && (await send.count()) === 0)
    await page.getByRole('dialog', { name: 'Command' }).getByRole('button', { name: 'Close' }).click()
    await degas(page, async (dialog, send) => {
      if ((await send.count()) === 0) return false
      await send.click()
      const done = dialog.getByText('Done: ba.degas-on')
      await done.or(dialog.locator('.error')).first().waitFor()
      return (await done.count()) === 1
    })
    const rows = await own.json('/api/audit?gauge=bcg450%205')
    const told = rows.filter(({ target }) => target?.startsWith('Hot Cathode Block State Command'))
    assert.deepEqual([told[0].action, told[0].outcome, told.at(-1).action], ['outcome', 'done', 'refused'])
    assert.deepEqual(
      complaints.filter((complaint) => !REFUSAL.test(complaint)),
      [],
    )
  } finally {
    await close()
    await own.stop()
  }
})

test('a recording that has just begun fills the chart', async () => {
  const own = await startDemo()
  const { page, close } = await openPage(browser, `${own.url}/trends`)
  try {
    await drawn(page)
    const { from, to } = await page.locator('.chart').evaluate(({ dataset }) => ({ ...dataset }))
    assert.ok(to - from < 60_000, `${to - from} ms`)
  } finally {
    await close()
    await own.stop()
  }
})
