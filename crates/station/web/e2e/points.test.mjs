// The points of slaves beside a gauge, and on the trends page: each unit on an axis of its own, a code in steps, and the values at the
// cursor.

import assert from 'node:assert/strict'
import { mkdtemp, rm, writeFile } from 'node:fs/promises'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after, before, test } from 'node:test'
import { openPage, startBrowser, startGauges, startStation } from './setup.mjs'

let browser
let slave
let station
let folder

const PUMP = `#Profibus_DP
Vendor_Name = "Invented"
Model_Name = "Pump 1"
Ident_Number = 0x0FA1
19.2_supp = 1
MaxTsdr_19.2 = 60
Modular_Station = 1
Max_Module = 1
Max_Input_Len = 8
Max_Output_Len = 0
Max_Data_Len = 8
Module = "Speed" 0x52
1
EndModule
`

const VALVE = `#Profibus_DP
Vendor_Name = "Invented"
Model_Name = "Valve 7"
Ident_Number = 0x0FA7
19.2_supp = 1
MaxTsdr_19.2 = 60
Max_Input_Len = 2
Max_Output_Len = 1
Module = "Position" 0x11,0x20
1
EndModule
`

const plant = (port) => `
[[segment]]
name = "hall"
port = "${port}"
baud = 19200

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"

[[segment.slave]]
name = "turbo"
address = 12
gsd = "pump.gsd"
modules = [1]
own = true

[[segment.slave.point]]
name = "speed"
type = "u16"
unit = "Hz"

[[segment.slave.point]]
name = "current"
octet = 2
type = "i16"
scale = 0.01
unit = "A"

[[segment.slave.point.alarm]]
above = 0.8
delay = "0 s"

[[segment.slave.point]]
name = "state"
octet = 4
type = "u8"
texts = { 0 = "off", 2 = "at speed" }

[[segment.slave]]
name = "gate"
address = 13
gsd = "valve.gsd"
own = true
outputs = "01"

[[segment.slave.point]]
name = "position"
type = "u8"
unit = "mm"

[[segment.slave.point]]
name = "limit switch"
octet = 1
bit = 0
type = "bool"
texts = { 0 = "open", 1 = "closed" }
`

before(async () => {
  folder = await mkdtemp(join(tmpdir(), 'profivac-points-'))
  const [pump, valve, file] = ['pump.gsd', 'valve.gsd', 'plant.toml'].map((name) => join(folder, name))
  await writeFile(pump, PUMP)
  await writeFile(valve, VALVE)
  const words = ['bcg450@5', `${pump}@12:modules=1`, `${valve}@13:modules=1`]
  ;[browser, slave] = await Promise.all([startBrowser(), startGauges(...words)])
  // 1000 Hz, 1.00 A, state 2; 40 mm and closed.
  slave.tell('input 12 1 03 E8 00 64 02 00')
  slave.tell('input 13 1 28 01')
  await writeFile(file, plant(slave.port))
  station = await startStation(file)
})

after(async () => {
  await browser?.close()
  await station?.stop()
  await slave?.stop()
  await rm(folder, { recursive: true, force: true })
})

/** Opens a page and looks at it. */
async function visit(path, look) {
  const { page, complaints, close } = await openPage(browser, station.url + path)
  try {
    await look(page)
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
}

test('the overview shows a gauge, a pump controller and a valve of one segment', async () => {
  await visit('/', async (page) => {
    const value = (name, point) => page.locator(`[data-gauge="${name}"] [data-point="${point}"]`)
    await value('turbo', 'speed').getByText('1000 Hz').waitFor()
    await value('turbo', 'state').getByText('at speed').waitFor()
    await value('gate', 'position').getByText('40 mm').waitFor()
    await value('gate', 'limit switch').getByText('closed').waitFor()
    await page.locator('[data-gauge="chamber"]').getByText('mbar').first().waitFor()
  })
})

test('an alarm about a point has its value in the line of the overview, and the wall names the point of its tile', async () => {
  await visit('/', async (page) => {
    const line = page.getByRole('list', { name: 'Active alarms' }).getByRole('listitem')
    await line.getByText('turbo: current above 0.8 A').waitFor()
    assert.equal(await line.locator('.condition').innerText(), 'turbo: current is 1 A')
    await page.goto(`${station.url}/wall`)
    const tile = page.locator('.wall-tile[data-series="turbo"]')
    await tile.getByText('1000 Hz').waitFor()
    assert.equal(await tile.locator('.wall-quality').innerText(), 'speed')
    assert.match(await page.locator('.wall-tile[data-series="gate"] .wall-state').innerText(), /^position/)
  })
})

test('the card of a slave does not cut the name of its device without a sign', async () => {
  await visit('/', async (page) => {
    const device = page.locator('[data-gauge="turbo"] .card-foot .device')
    await device.evaluate((one) => {
      one.textContent = 'A name that is longer than the card of a gauge has room for on any page'
    })
    const [style, inside] = await device.evaluate((one) => {
      const [own, card] = [one, one.closest('.card')].map((it) => it.getBoundingClientRect().right)
      return [getComputedStyle(one).textOverflow, own <= card]
    })
    assert.deepEqual([style, inside], ['ellipsis', true])
    assert.ok(await device.getAttribute('title'))
  })
})

const list = (page) => page.getByRole('group', { name: 'Points of slaves' })

/** The charts below that of the pressures. */
const charts = (page) => page.locator('.trend-chart + .trend-chart .chart')

test('a marked point has a chart with its unit, and the address of the page has it', async () => {
  await visit('/trends?last=60000', async (page) => {
    await list(page).getByText('1000 Hz').waitFor()
    assert.equal(await charts(page).count(), 0)
    for (const name of ['turbo.speed', 'turbo.current', 'turbo.state']) await list(page).getByLabel(name).check()
    await charts(page).nth(2).waitFor()
    const units = await charts(page).evaluateAll((all) => all.map((chart) => chart.dataset.unit))
    assert.deepEqual(units, ['Hz', 'A', ''])
    const drawn = await charts(page).evaluateAll((all) => all.map((chart) => Number(chart.dataset.points)))
    assert.ok(
      drawn.every((count) => count > 0),
      `${drawn}`,
    )
    assert.deepEqual(new URL(page.url()).searchParams.getAll('p'), ['turbo.speed', 'turbo.current', 'turbo.state'])
    await list(page).getByLabel('turbo.current').uncheck()
    await page.waitForFunction(() => document.querySelectorAll('.trend-chart + .trend-chart .chart').length === 2)
  })
})

test('the list shows the recorded values at the cursor', async () => {
  await visit('/trends?last=60000&p=turbo.speed&p=turbo.state', async (page) => {
    await charts(page).nth(1).waitFor()
    const plot = await charts(page).nth(0).locator('.u-over').boundingBox()
    await page.mouse.move(plot.x + plot.width - 2, plot.y + plot.height / 2)
    // The page fetches the trends again until they have the first values.
    await page.waitForFunction(() => {
      const values = [...document.querySelectorAll('.point-list .value')].map(({ textContent }) => textContent)
      return (
        document.querySelector('.cursor-time strong')?.textContent !== 'now' && values.join() === '1000 Hz,,at speed,,'
      )
    })
    await page.mouse.move(plot.x + 2, plot.y + plot.height / 2)
    await list(page).getByText('no data').first().waitFor()
  })
})

test('the points of the window are saved with their units', async () => {
  await visit('/trends?last=3600000', async (page) => {
    const saved = page.waitForEvent('download')
    await list(page).getByText('Save points as CSV').click()
    const stream = await (await saved).createReadStream()
    const rows = (await stream.toArray()).join('').trim().split('\n')
    assert.equal(rows[0], 'time,slave,point,unit,value,quality,text')
    assert.ok(
      rows.some((row) => /turbo,speed,Hz,1000,valid,$/.test(row)),
      rows.slice(0, 5).join('\n'),
    )
    assert.ok(rows.some((row) => /turbo,state,,2,valid,at speed$/.test(row)))
  })
})
