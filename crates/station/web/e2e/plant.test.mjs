// The picture of the plant: the demonstration with its story, and a station whose file describes a plant.

import assert from 'node:assert/strict'
import { mkdtemp, rm, writeFile } from 'node:fs/promises'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after, before, test } from 'node:test'
import { openContext, openPage, startBrowser, startLastingDemo, startPlant, startStation } from './setup.mjs'

let browser
let demo
let station
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

before(async () => {
  folder = await mkdtemp(join(tmpdir(), 'profivac-plant-'))
  await writeFile(join(folder, 'hall.toml'), FILE)
  ;[browser, demo, station] = await Promise.all([
    startBrowser(),
    startLastingDemo('--speed', '3'),
    startStation(join(folder, 'hall.toml')),
  ])
})

after(async () => {
  await browser?.close()
  await Promise.all([demo?.stop(), station?.stop()])
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
    assert.match(await chamber.getAttribute('aria-label'), /^chamber: .*, from .* and \d+ more/)
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
  })
})

test('the list has what the picture has', async () => {
  await visit(`${demo.url}/plant`, async (page) => {
    const chamber = page.locator('[data-list-volume="chamber"]')
    for (const series of ['bcg450 5', 'tpg500 15.1', 'img400 16.4'])
      await chamber.getByRole('link', { name: series, exact: true }).waitFor()
    assert.equal(await chamber.getByRole('link', { name: 'tpg500 15.2', exact: true }).count(), 0)
    const foreLine = page.locator('[data-list-volume="fore-line"]')
    await foreLine.getByRole('link', { name: 'tpg500 15.2', exact: true }).waitFor()
    assert.match(await page.locator('[data-list-part="turbo"]').innerText(), /turbo pump\s+runs/)
  })
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
    assert.equal(await page.locator('.plant-picture script, .plant-picture b').count(), 0)
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
  const { page, close } = await openPage(browser, `${mortal.url}/plant`)
  try {
    await part(page, 'scroll').and(page.locator('.open')).waitFor()
    await mortal.stop()
    await page.locator('.connection.lost').waitFor()
    const told = (selector) => page.locator(selector).allTextContents()
    assert.deepEqual([...new Set(await told('.plant-picture .part:not(.tube) .state'))], ['not reported'])
    assert.equal(await page.locator('.plant-picture .line:is(.open, .closed)').count(), 0)
    assert.deepEqual([...new Set(await told('[data-list-part] td:nth-child(3)'))], ['not reported'])
  } finally {
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
