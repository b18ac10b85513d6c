// The wall display: large values without controls, the problems first.

import assert from 'node:assert/strict'
import { mkdtemp, rm, writeFile } from 'node:fs/promises'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after, before, test } from 'node:test'
import { becomes, openContext, openPage, startBrowser, startPlant, startStation } from './setup.mjs'

let browser
let large
let hall
let folder

/** A controller in memory with two channels below their range; alarms about a channel, a gauge and two segments. */
const LINE = 'devices = ["tpg300@14"]\npressure = "1e-5 mbar"\n'
const FILE = `
[[segment]]
name = "hall"
port = "sim:line.toml"

[[segment.gauge]]
name = "pump stand"
address = 14
device = "tpg300"

${['attic', 'cellar', 'yard', 'roof']
  .map((name) => `[[segment]]\nname = "${name}"\nport = "no-such-${name}"\n`)
  .join('\n')}
[[alarm]]
name = "second channel evacuated"
gauge = "pump stand.2"
below = "1e-2 mbar"
delay = "0 s"

[alarms]
segment = { delay = "0 s" }
`

before(async () => {
  folder = await mkdtemp(join(tmpdir(), 'profivac-wall-'))
  for (const [name, text] of Object.entries({ 'line.toml': LINE, 'hall.toml': FILE }))
    await writeFile(join(folder, name), text)
  ;[browser, large, hall] = await Promise.all([
    startBrowser(),
    startPlant('127.0.0.1:0', 'large'),
    startStation(join(folder, 'hall.toml')),
  ])
})

after(async () => {
  await browser?.close()
  await Promise.all([large?.stop(), hall?.stop()])
  await rm(folder, { recursive: true, force: true })
})

async function openWall(url, options = {}) {
  const opened = await openContext(browser, { viewport: { width: 1920, height: 1080 }, ...options })
  await opened.page.goto(url)
  await opened.page.locator('.wall-tile').first().waitFor()
  return opened
}

const series = (page) => page.locator('.wall-tile').evaluateAll((tiles) => tiles.map(({ dataset }) => dataset.series))

/** What the wall display cuts off: a part of the page, tiles, values, marks of alarms. */
const cutOff = (page) =>
  page.evaluate(() => {
    const { scrollHeight, clientHeight } = document.documentElement
    const display = document.querySelector('.wall-tiles').getBoundingClientRect()
    const isCut = (tile) => tile.getBoundingClientRect().bottom > display.bottom + 1
    const isShortened = (value) => value.scrollWidth > value.clientWidth
    const isCutMark = (mark) => {
      const [own, around] = [mark, mark.closest('.wall-state')].map((one) => one.getBoundingClientRect())
      return own.left < around.left || own.top < around.top || own.bottom > around.bottom
    }
    return [
      scrollHeight > clientHeight,
      [...document.querySelectorAll('.wall-tile')].filter(isCut).length,
      [...document.querySelectorAll('.wall-value')].filter(isShortened).length,
      [...document.querySelectorAll('.wall-tile .shape')].filter(isCutMark).length,
    ]
  })

test('480 gauges fit on one page: the problems, and the quiet gauges of each segment on one tile; nothing is a control or is cut off', async () => {
  for (const locale of ['en-GB', 'de-DE']) {
    const { page, complaints, close } = await openWall(`${large.url}/wall`, { locale })
    try {
      const beamLine = page.locator('[data-segment="beam line"]')
      await beamLine.getByText(/^\d+ (gauges without a problem|Messgeräte ohne Problem)$/).waitFor()
      assert.equal(await beamLine.locator('.pressure').count(), 2, 'the lowest and the highest pressure')
      await becomes(() => page.locator('.wall-page').count(), 0)
      assert.equal((await series(page))[0], 'gate 2')
      const quiet = await page
        .locator('[data-segment] .wall-state')
        .evaluateAll((states) => states.map(({ innerText }) => Number.parseInt(innerText, 10)))
      const problems = new Set(await series(page).then((names) => names.filter((name) => name !== undefined)))
      assert.equal(quiet.reduce((one, other) => one + other) + problems.size, 480)
      await becomes(() => page.locator('a, button, input, select, summary, [tabindex="0"]').count(), 0)
      assert.deepEqual(await cutOff(page), [false, 0, 0, 0])
      assert.deepEqual(complaints, [])
    } finally {
      await close()
    }
  }
})

test('what does not fit turns in pages, and the problems stay', async () => {
  const { page, complaints, close } = await openWall(`${large.url}/wall`, { viewport: { width: 1024, height: 600 } })
  try {
    await page
      .locator('.wall-page')
      .getByText(/^page \d+ of \d+$/)
      .waitFor()
    const key = ({ dataset }) => dataset.segment ?? dataset.series
    const last = page.locator('.wall-tile').last()
    const before = await last.evaluate(key)
    await page.waitForFunction(
      (before) =>
        ![...document.querySelectorAll('.wall-tile')].some(
          ({ dataset }) => (dataset.segment ?? dataset.series) === before,
        ),
      before,
    )
    assert.equal((await series(page))[0], 'gate 2')
    assert.deepEqual(await cutOff(page), [false, 0, 0, 0])
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
})

test('an alarm about a channel stands on its tile alone, beside the word for the range', async () => {
  const { page, complaints, close } = await openWall(`${hall.url}/wall`)
  try {
    const tile = (channel) => page.locator(`.wall-tile[data-series="pump stand.${channel}"]`)
    await tile(2).getByText('medium second channel evacuated').waitFor()
    await tile(2).getByText('under range', { exact: true }).waitFor()
    await tile(1).getByText('under range', { exact: true }).waitFor()
    await becomes(() => page.locator('.wall-tile .priority').count(), 1)
    const isCut = ({ scrollHeight, clientHeight }) => scrollHeight > clientHeight
    assert.equal(await tile(2).evaluate(isCut), false, 'three lines fit')
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
})

test('alarms without a gauge have lines of their own, at most three, and the head counts each priority', async () => {
  const { page, complaints, close } = await openWall(`${hall.url}/wall`)
  try {
    // The segment of the gauge can have an alarm until it runs, which is then one more to acknowledge.
    // The text of the whole element has the short words too, which are hidden here.
    await page.waitForFunction(() =>
      /4 high, 1 medium, [56] not acknowledged/.test(document.querySelector('.wall-head').innerText),
    )
    const lines = page.getByRole('list', { name: 'Alarms without a gauge' }).getByRole('listitem')
    await lines.nth(3).waitFor()
    const texts = await lines.allInnerTexts()
    for (const text of texts.slice(0, 3))
      assert.match(text, /^1\s+high segment \w+: down segment \w+ is not running or gives no data$/)
    assert.equal(texts[3], 'and 1 more')
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
})

test('the clock of the wall display is in the first line at every width, in both languages', async () => {
  for (const locale of ['en-GB', 'de-DE']) {
    const { page, close } = await openWall(`${hall.url}/wall`, { locale })
    try {
      await page.locator('.wall-head', { hasText: /not acknowledged|nicht quittiert/ }).waitFor()
      for (const width of [360, 480, 700, 900, 1024, 1280, 1920]) {
        await page.setViewportSize({ width, height: 740 })
        const [name, time] = await page
          .locator('.wall-head')
          .evaluate((head) =>
            ['strong', 'time'].map((part) => [...head.querySelector(part).getClientRects()].map(({ top }) => top)),
          )
        assert.ok(time.length === 1 && Math.abs(time[0] - name[0]) < 12, `${locale} ${width}: ${name} ${time}`)
        assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= width)
      }
    } finally {
      await close()
    }
  }
})

test('the wall display has the filter of the overview, is dark by default, and Escape leads back', async () => {
  const { page, complaints, close } = await openPage(browser, `${large.url}/?group=beam+line`, {
    colorScheme: 'light',
    viewport: { width: 1920, height: 1080 },
  })
  try {
    await page.getByRole('link', { name: 'Wall display' }).click()
    await page.locator('.wall-tile[data-series="vessel"]').waitFor()
    assert.ok((await series(page)).includes('pump stand.4') && !(await series(page)).includes('oven'))
    await becomes(() => page.locator('.wall-page').count(), 0)
    const [theme, size] = await page.evaluate(() => {
      const value = getComputedStyle(document.querySelector('.wall-value'))
      return [document.documentElement.dataset.theme, Number.parseFloat(value.fontSize)]
    })
    assert.equal(theme, 'dark')
    assert.ok(size > 35, `${size} pixels`)
    await page.keyboard.press('Escape')
    await page.waitForURL(/\/\?group=beam\+line$/)
    await page.getByLabel('Search gauges').waitFor()
    assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), 'auto')
    await page.goto(`${large.url}/wall?theme=light&state=alarms`)
    await page.locator('.wall-tile').first().waitFor()
    assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), 'light')
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
})

test('a wall display without its station says for how long, and goes on when the station is back', async () => {
  let mortal = await startPlant()
  const { address } = mortal
  const { page, close } = await openWall(`${mortal.url}/wall`)
  try {
    await becomes(() => page.getByRole('alert').count(), 0)
    await mortal.stop()
    await page
      .getByRole('alert')
      .getByText(/No connection to the station for [\d.]+ s/)
      .waitFor()
    await page.locator('.wall-tile.stale[data-series="chamber"]', { hasText: 'no data' }).waitFor()
    mortal = await startPlant(address)
    await page.locator('.wall-tile:not(.stale)[data-series="chamber"]').waitFor()
    await page.getByRole('alert').waitFor({ state: 'detached' })
  } finally {
    await close()
    await mortal.stop()
  }
})
