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
    await page.waitForFunction(([element, first]) => element.innerText !== first, [await chamber.elementHandle(), first])
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
