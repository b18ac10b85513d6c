// The dashboard over the demo plant: every octet behind these numbers went through the codec and both state machines.

import assert from 'node:assert/strict'
import { after, before, test } from 'node:test'
import { drawn, openPage, startBrowser, startDemo } from './desk.mjs'

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

test('all twelve devices measure, and their pressures fall', async () => {
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

test('parameters of a gauge are read over the bus', async () => {
  const blocks = await demo.json(`/api/gauges/${encodeURIComponent('bcg450 5')}/blocks`)
  const values = blocks.flatMap(({ parameters }) => parameters).filter(({ value }) => value !== null)
  assert.ok(values.length > 50, `${values.length} values`)
})

test('the pump-down is drawn', async () => {
  await visit('/trends', drawn)
})

test('the chamber is full of air at first: that is an alarm, and it is over when it has been pumped down', async () => {
  await visit('/alarms', async (page) => {
    const chamber = page.locator('[data-alarm="chamber above 1e-3 mbar"]')
    await chamber.waitFor()
    assert.match(await chamber.innerText(), /Is a flange open/)
    await page.waitForFunction(async () => {
      const all = await (await fetch('/api/alarms')).json()
      return ['returned', 'normal'].includes(all.find(({ name }) => name === 'chamber above 1e-3 mbar').state)
    })
  })
})

/** A refusal is an answer that the console calls an error. */
const REFUSAL = /the server responded with a status of 409/

/** Arms a degas until the panel shows what is wanted: the plant goes on meanwhile, and so does the gauge. */
async function degasses(page, wanted) {
  const panel = page.getByRole('dialog', { name: 'Order' })
  for (;;) {
    await page.locator('[data-command="ba.degas-on"] button').click()
    const fire = panel.getByRole('button', { name: 'Fire' })
    await fire.or(panel.locator('.alarm')).first().waitFor()
    if (await wanted(panel, fire)) return
    await panel.getByRole('button', { name: /Close|Disarm/ }).click()
    await panel.waitFor({ state: 'hidden' })
  }
}

test('a degas is refused while the pressure is too high and done when it is low; the alarm of the chamber is acknowledged', async () => {
  const own = await startDemo()
  const { page, complaints, close } = await openPage(browser, `${own.url}/gauge/bcg450%205`)
  try {
    await page.locator('.mastership').getByRole('button', { name: 'Ask' }).click()
    await page.locator('.mastership', { hasText: 'You act' }).waitFor()
    const fails = (panel) => panel.locator('.conditions .fails', { hasText: 'ba.process-value is below 7.2e-6 mbar' })
    await degasses(page, async (panel, fire) => (await fails(panel).count()) === 1 && (await fire.count()) === 0)
    await page.getByRole('dialog', { name: 'Order' }).getByRole('button', { name: 'Close' }).click()
    await page.goto(`${own.url}/alarms`)
    const chamber = page.locator('[data-alarm="chamber above 1e-3 mbar"]')
    await chamber.getByRole('button', { name: 'Acknowledge' }).click()
    await chamber.getByRole('button', { name: 'Acknowledge' }).waitFor({ state: 'detached' })
    const history = await own.json('/api/alarms/history?from=0&to=9999999999999&alarm=chamber+above+1e-3+mbar')
    assert.equal(history.find(({ what }) => what === 'acknowledged').who, 'demo')
    await page.goto(`${own.url}/gauge/bcg450%205`)
    await degasses(page, async (panel, fire) => {
      if ((await fire.count()) === 0) return false
      await fire.click()
      const done = panel.getByText('Done: ba.degas-on')
      await done.or(panel.locator('.alarm')).first().waitFor()
      return (await done.count()) === 1
    })
    const rows = await own.json('/api/audit?gauge=bcg450%205')
    const told = rows.filter(({ target }) => target?.startsWith('Hot Cathode Block State Command'))
    assert.deepEqual([told[0].what, told[0].outcome, told.at(-1).what], ['outcome', 'done', 'refused'])
    assert.deepEqual(
      complaints.filter((complaint) => !REFUSAL.test(complaint)),
      [],
    )
  } finally {
    await close()
    await own.stop()
  }
})
