// The picture of the plant: the demonstration with its story, and a station whose file describes a plant.

import assert from 'node:assert/strict'
import { mkdtemp, rm, writeFile } from 'node:fs/promises'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after, before, test } from 'node:test'
import { violations } from './axe.mjs'
import { becomes, openContext, openPage, startBrowser, startLastingDemo, startPlant, startStation } from './setup.mjs'

let browser
let demo
let station
let bounds
let folder

/** A hall whose port is missing: its gauges have no data. */
const FILE = `
[[segment]]
name = "hall"
port = "no-such-port"

[[segment.gauge]]
name = "ion"
address = 5
device = "bcg450"

[[volume]]
name = "chamber"
zone = "target <b>"
gauges = ["ion"]

[[volume]]
name = "<script>alert(1)</script>"

[[valve]]
name = "gate"
between = ["chamber", "<script>alert(1)</script>"]

[[pump]]
name = "scroll"
kind = "roughing"
inlet = "<script>alert(1)</script>"
`

/** A controller in memory: its channels 1 and 2 are below their range, and another gauge is missing. */
const LINE = 'devices = ["tpg300@14"]\npressure = "1e-5 mbar"\n'
const BOUNDS = `
[[segment]]
name = "hall"
port = "sim:line.toml"

[[segment.gauge]]
name = "tpg"
address = 14
device = "tpg300"

[[segment]]
name = "attic"
port = "no-such-port"

[[segment.gauge]]
name = "far"
address = 5
device = "bcg450"

[[volume]]
name = "lock"
gauges = ["tpg.1"]

[[volume]]
name = "chamber"
zone = "target"
gauges = ["far", "tpg"]

[[alarm]]
name = "evacuated"
gauge = "tpg.3"
below = "1e-2 mbar"
delay = "0 s"
priority = "high"

[[alarm]]
name = "evacuated too"
gauge = "tpg.4"
below = "1e-2 mbar"
delay = "0 s"
priority = "low"
`

before(async () => {
  folder = await mkdtemp(join(tmpdir(), 'profivac-plant-'))
  for (const [name, text] of Object.entries({ 'hall.toml': FILE, 'line.toml': LINE, 'bounds.toml': BOUNDS }))
    await writeFile(join(folder, name), text)
  ;[browser, demo, station, bounds] = await Promise.all([
    startBrowser(),
    startLastingDemo('--speed', '3'),
    startStation(join(folder, 'hall.toml')),
    startStation(join(folder, 'bounds.toml')),
  ])
})

after(async () => {
  await browser?.close()
  await Promise.all([demo?.stop(), station?.stop(), bounds?.stop()])
  await rm(folder, { recursive: true, force: true })
})

async function visit(url, look, options = {}) {
  const { page, complaints, close } = await openPage(browser, url, options)
  try {
    await look(page)
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
}

const volume = (page, name) => page.locator(`.plant-picture [data-volume="${name}"]`)
const part = (page, name) => page.locator(`.plant-picture [data-part="${name}"]`)
const state = (page, name) => part(page, name).locator('.state')

test('the picture of the demonstration has its volumes with live pressures, its valves and its pumps', async () => {
  await visit(`${demo.url}/plant`, async (page) => {
    for (const name of ['chamber', 'throat', 'exhaust', 'fore-line']) await volume(page, name).waitFor()
    for (const name of ['gate', 'bypass', 'backing', 'turbo', 'scroll']) await part(page, name).waitFor()
    await state(page, 'scroll').getByText('runs').waitFor()
    const chamber = await volume(page, 'chamber').locator('.value').elementHandle()
    const first = await chamber.textContent()
    assert.match(first, / mbar$/)
    await page.waitForFunction(([element, first]) => element.textContent !== first, [chamber, first])
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)) <= 0)
  })
})

test('the longest pressure fits into its volume, in the longest unit', async () => {
  await visit(`${demo.url}/plant`, async (page) => {
    await page.getByLabel('Unit of pressure').selectOption('micron')
    await volume(page, 'throat')
      .locator('.value', { hasText: /^< .* micron$/ })
      .waitFor()
    const rooms = await page.locator('.plant-picture [data-volume]').evaluateAll((all) =>
      all.map((one) => {
        const [text, edge] = [one.querySelector('.value'), one.querySelector('.volume-edge')].map((it) => it.getBBox())
        return edge.x + edge.width - text.x - text.width
      }),
    )
    assert.ok(rooms.length === 4 && rooms.every((room) => room > 5), `${rooms} beside the texts`)
  })
})

test('the overview begins with the picture, which leads to the gauge by key', async () => {
  await visit(demo.url, async (page) => {
    const chamber = volume(page, 'chamber')
    await chamber.waitFor()
    assert.match(await chamber.getAttribute('aria-label'), /^chamber: .*, .* and \d+ more/)
    await chamber.focus()
    await page.keyboard.press('Enter')
    await page.waitForURL(/\/gauge\//)
    await page.getByRole('heading', { level: 1 }).waitFor()
  })
})

test('on a phone the plant goes from top to bottom and fits', async () => {
  const phone = { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true }
  await visit(
    `${demo.url}/plant`,
    async (page) => {
      const [chamber, throat] = [volume(page, 'chamber'), volume(page, 'throat')]
      await throat.waitFor()
      const [above, below] = [await chamber.boundingBox(), await throat.boundingBox()]
      assert.ok(above.y + above.height < below.y)
      assert.ok((await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)) <= 0)
    },
    phone,
  )
})

test('the story is told as it happens, and the states follow it', async () => {
  await visit(`${demo.url}/plant`, async (page) => {
    const story = page.getByRole('region', { name: 'What happens' })
    await story.getByRole('status').getByText('All gauges measure again.').waitFor({ timeout: 300_000 })
    await story.getByText('Before').click()
    await story.getByText('Incident: a flange leaks.').waitFor()
    await state(page, 'gate').getByText('open').waitFor()
    await state(page, 'bypass').getByText('closed').waitFor()
    assert.equal(await part(page, 'flange').count(), 0, 'the flange is tight')
    const [picture, chamber] = await Promise.all(
      [page.locator('.plant-picture svg'), volume(page, 'chamber')].map((one) => one.boundingBox()),
    )
    assert.ok(chamber.y - picture.y < 20, `${chamber.y - picture.y} pixels are empty above the chamber`)
  })
})

test('the list has what the picture has', async () => {
  await visit(`${demo.url}/plant`, async (page) => {
    const chamber = page.locator('[data-list-volume="chamber"]')
    for (const series of ['bcg450 5', 'tpg500 15.1', 'img400 16.4'])
      await chamber.getByRole('link', { name: series, exact: true }).waitFor()
    await becomes(() => chamber.getByRole('link', { name: 'tpg500 15.2', exact: true }).count(), 0)
    const foreLine = page.locator('[data-list-volume="fore-line"]')
    await foreLine.getByRole('link', { name: 'tpg500 15.2', exact: true }).waitFor()
    assert.match(await page.locator('[data-list-part="turbo"]').innerText(), /turbo pump\s+runs/)
  })
})

test('a picture from top to bottom stands beside the list, and beside the gauges of the overview', async () => {
  for (const [path, other] of [
    ['/plant', '.plant-lists'],
    ['/', '.card'],
  ]) {
    await visit(
      demo.url + path,
      async (page) => {
        await page.locator('.plant-picture[data-narrow="true"]').waitFor()
        const [picture, beside] = await Promise.all(
          ['.plant-picture', other].map((one) => page.locator(one).first().boundingBox()),
        )
        assert.ok(beside.x >= picture.x + picture.width && beside.y < picture.y + picture.height)
        // No sentence of the story makes the column wider.
        const column = await page.locator('.beside-picture > :first-child').first().boundingBox()
        assert.ok(column.width < 460, `the column has ${column.width} pixels`)
        // A window that becomes wider has the other direction again.
        await page.setViewportSize({ width: 1600, height: 900 })
        await page.locator('.plant-picture[data-direction="LR"]').waitFor()
        const [above, below] = await Promise.all(
          ['.plant-picture', other].map((one) => page.locator(one).first().boundingBox()),
        )
        assert.ok(below.y >= above.y + above.height)
      },
      { viewport: { width: 1280, height: 800 } },
    )
  }
})

test('on a wide page the list is open below the picture, and its pressures are aligned by decade', async () => {
  const wide = { viewport: { width: 1440, height: 900 } }
  await visit(
    `${demo.url}/plant`,
    async (page) => {
      await part(page, 'gate').waitFor()
      const powers = page.locator('[data-list-volume] .power')
      // The story begins at atmospheric pressure, which has no power of ten.
      await powers.nth(5).waitFor()
      const whole = await page.locator('main').evaluate((main) => main.getBoundingClientRect().bottom)
      assert.ok(whole >= 0.75 * 900, `the page ends at ${whole}`)
      const lefts = await powers.evaluateAll((all) => all.map((one) => one.getBoundingClientRect().left))
      assert.ok(lefts.length > 5 && Math.max(...lefts) - Math.min(...lefts) < 1, lefts.join(' '))
      // A screen reader and a copy get one line.
      const texts = await page.locator('[data-list-volume] .pressure').allInnerTexts()
      for (const text of texts) assert.match(text, /^\d+\.?\d*( × 10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)? mbar$/)
    },
    wide,
  )
  const phone = { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true }
  await visit(
    `${demo.url}/plant`,
    async (page) => {
      await page.getByText('As a list').click()
      const name = page.locator('[data-list-volume="chamber"] th')
      await name.waitFor()
      const lines = await name.evaluate((one) => {
        const range = document.createRange()
        range.selectNodeContents(one)
        return range.getClientRects().length
      })
      assert.equal(lines, 1, 'the name of a volume is in one line')
      assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 360)
    },
    phone,
  )
})

test('a volume has its source, the readings without a pressure, its alarms by priority and an edge in the colour of the highest', async () => {
  await visit(`${bounds.url}/plant`, async (page) => {
    const chamber = volume(page, 'chamber')
    await chamber.getByText('tpg.3 and 3 more', { exact: true }).waitFor()
    await chamber.getByText('1 of 4 without a pressure', { exact: true }).waitFor()
    await chamber.getByText('1 high, 1 low', { exact: true }).waitFor()
    assert.match(
      await chamber.getAttribute('aria-label'),
      /^chamber: .* mbar, tpg.3 and 3 more, 1 of 4 without a pressure, 1: 1 high, 1 low$/,
    )
    const stroke = (name) =>
      volume(page, name)
        .locator('.volume-edge')
        .evaluate((edge) => getComputedStyle(edge).stroke)
    const high = await chamber.locator('.alarm-shape.high').evaluate((shape) => getComputedStyle(shape).fill)
    assert.equal(await stroke('chamber'), high)
    assert.notEqual(await stroke('lock'), high)
    const frame = page.locator('[data-zone="target"] rect').first()
    assert.equal(await frame.evaluate((edge) => getComputedStyle(edge).stroke), high)
    const zones = page.getByRole('list', { name: 'Zones with active alarms' }).getByRole('listitem')
    assert.deepEqual(
      (await zones.allInnerTexts()).map((text) => text.replace(/\s+/g, ' ')),
      ['target: 1 1 high, 1 low'],
    )
    assert.deepEqual(await violations(page), [])
    const listed = page.locator('[data-list-volume="chamber"]')
    assert.match(await listed.innerText(), /1\s+1 high, 1 low/)
    const alarmed = listed.locator('li', { has: page.locator('.reading-alarm') })
    assert.deepEqual(
      (await alarmed.allInnerTexts()).map((text) => text.replace(/\s+/g, ' ').trim()),
      ['tpg.3 1.00 × 10⁻⁵ mbar 1 high evacuated', 'tpg.4 1.00 × 10⁻⁵ mbar 3 low evacuated too'],
    )
  })
})

test('the end of a range is hatched, as the scale says, also on the overview, and is hollow on the line of decades', async () => {
  for (const path of ['/plant', '/']) {
    await visit(bounds.url + path, async (page) => {
      const fill = (name) =>
        volume(page, name)
          .locator('.volume-shade')
          .evaluate((shade) => getComputedStyle(shade).fill)
      await volume(page, 'lock').getByText('< 8.00 × 10⁻⁴').waitFor()
      assert.match(await fill('lock'), /^url\(.*#hatching/)
      assert.match(await fill('chamber'), /^rgb/)
      // The powers of ten of the scale are marked on each line.
      const lines = await page.locator('.decades').first().locator('line').count()
      assert.equal(lines, 1 + (await page.locator('.shade-step').count()) - 1)
      const points = await page.locator('.decades circle').evaluateAll((all) =>
        all.map((point) => {
          const volume = point.closest('[data-volume]')
          const edge = volume.querySelector('.volume-edge').getBBox()
          const part = (Number(point.getAttribute('cx')) - edge.x) / edge.width
          return [volume.dataset.volume, part, getComputedStyle(point).fill === getComputedStyle(point).stroke]
        }),
      )
      const [lock, chamber] = ['lock', 'chamber'].map((name) => points.find(([other]) => other === name))
      assert.deepEqual([lock[2], chamber[2]], [false, true])
      assert.ok(lock[1] > chamber[1], `${lock[1]} and ${chamber[1]}`)
      await page.locator('.shade-scale').getByText('< or >, end of the range').waitFor()
      await becomes(() => page.locator('.shade-scale #hatching').count(), 1)
    })
  }
})

test('a file may describe the plant; what nothing reports is named, and names are only text', async () => {
  const plant = await station.json('/api/plant')
  assert.deepEqual(plant.parts[0], {
    name: 'gate',
    kind: 'valve',
    volumes: ['chamber', '<script>alert(1)</script>'],
  })
  await visit(`${station.url}/plant`, async (page) => {
    await volume(page, 'chamber').getByText('no data').waitFor()
    await state(page, 'gate').getByText('not reported').waitFor()
    await page.locator('[data-zone="target <b>"]').getByText('target <b>').waitFor()
    await becomes(() => page.locator('.plant-picture script, .plant-picture b').count(), 0)
  })
})

test('a station without a plant says how to describe one', async () => {
  const plain = await startPlant()
  try {
    await visit(`${plain.url}/plant`, async (page) => {
      await page.getByText('The station’s file describes no plant.').waitFor()
    })
  } finally {
    await plain.stop()
  }
})

test('the picture comes also when the first request for it has no answer', async () => {
  const { page, close } = await openContext(browser)
  try {
    let requests = 0
    await page.route('**/api/plant', (route) => {
      requests += 1
      return requests === 1 ? route.abort() : route.continue()
    })
    await page.goto(`${station.url}/plant`)
    await page.locator('.plant-picture svg').first().waitFor()
    assert.equal(requests, 2)
  } finally {
    await close()
  }
})

test('without a connection valves and pumps are not reported, in the picture and in the list', async () => {
  const mortal = await startLastingDemo('--speed', '3')
  const phone = { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true }
  const { page, close } = await openPage(browser, `${mortal.url}/plant`)
  const phones = []
  for (const locale of ['en-GB', 'de-DE'])
    for (const path of ['/', '/plant']) phones.push(await openPage(browser, mortal.url + path, { ...phone, locale }))
  try {
    for (const opened of [...phones, { page }])
      await opened.page.locator('.plant-picture [data-part="scroll"].open').waitFor()
    await mortal.stop()
    for (const opened of [...phones, { page }]) await opened.page.locator('.connection.lost').waitFor()
    for (const { page } of phones) {
      const [lost, menu] = await Promise.all(
        ['.connection.lost', '.menu'].map((part) => page.locator(`header ${part}`).boundingBox()),
      )
      assert.ok(lost.x + lost.width <= menu.x, `${lost.x + lost.width}: the lost connection is beside the menu`)
      const { room, cut } = await page.locator('.plant-picture').evaluate((picture) => {
        const { right } = picture.getBoundingClientRect()
        const isCut = (text) => text.getBoundingClientRect().right > right
        const cut = [...picture.querySelectorAll('text')].filter(isCut).map(({ textContent }) => textContent)
        return { room: picture.clientWidth - picture.scrollWidth, cut }
      })
      assert.deepEqual([room, cut], [0, []], 'the picture fits a phone')
    }
    const weight = (name) =>
      part(page, name)
        .locator('.name')
        .evaluate((text) => getComputedStyle(text).fontWeight)
    assert.equal(await weight('flange'), await weight('gate'), 'a leak that is not reported is no incident')
    const told = (selector) => page.locator(selector).allTextContents()
    assert.deepEqual([...new Set(await told('.plant-picture .part:not(.tube) .state'))], ['not reported'])
    await becomes(() => page.locator('.plant-picture .line:is(.open, .closed)').count(), 0)
    assert.deepEqual([...new Set(await told('[data-list-part] td:nth-child(3)'))], ['not reported'])
  } finally {
    for (const { close } of phones) await close()
    await close()
    await mortal.stop()
  }
})

test('on a German page the story is marked as English', async () => {
  await visit(
    `${demo.url}/plant`,
    async (page) => {
      const text = page.locator('.story-latest span:not(.story-time)')
      await text.waitFor()
      assert.equal(await text.evaluate((element) => element.closest('[lang]').lang), 'en')
    },
    { locale: 'de-DE' },
  )
})
