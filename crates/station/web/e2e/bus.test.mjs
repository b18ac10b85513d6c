// The statistics of a bus in a browser: a station with a master on a segment in memory; `cargo build -p profivac-cli` makes the program.

import assert from 'node:assert/strict'
import { mkdtemp, rm, writeFile } from 'node:fs/promises'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after, before, test } from 'node:test'
import { becomes, openPage, startBrowser, startStation } from './setup.mjs'

let browser
let station
let folder

before(async () => {
  folder = await mkdtemp(join(tmpdir(), 'profivac-bus-'))
  await writeFile(join(folder, 'hall.toml'), 'devices = ["bcg450@5"]\nbaud = 187500\n')
  const lines = [
    '[[segment]]\nname = "hall"\nbaud = 187500\nmaster = 1',
    `port = "sim:${join(folder, 'hall.toml')}"`,
    '[[segment.gauge]]\nname = "chamber"\naddress = 5\ndevice = "bcg450"\n',
  ]
  await writeFile(join(folder, 'plant.toml'), lines.join('\n'), { mode: 0o600 })
  ;[browser, station] = await Promise.all([startBrowser(), startStation(join(folder, 'plant.toml'))])
})

after(async () => {
  await browser?.close()
  await station?.stop()
  await rm(folder, { recursive: true, force: true })
})

test('the statistics of the bus show stations, times and events, and a viewer makes no capture', async () => {
  const { page, complaints, close } = await openPage(browser, `${station.url}/bus`)
  try {
    await page.getByText('Statistics, events and captures').first().click()
    const statistics = page.locator('details.statistics').first()
    const rows = statistics.locator('table', { hasText: 'Stations, with their counts' }).locator('tbody tr')
    await rows.filter({ hasText: 'exchanging' }).waitFor()
    await becomes(() => rows.locator('th').allInnerTexts(), ['1', '5'])
    await becomes(() => rows.locator('td:nth-of-type(1)').allInnerTexts(), ['master', 'exchanging'])
    await statistics.getByText('Cycle time').waitFor()
    const bar = statistics.locator('.histogram .bar-of-counts rect').first()
    await bar.waitFor({ state: 'attached' })
    const [fill, neutral] = await bar.evaluate((element) => {
      const probe = element.ownerDocument.body.appendChild(document.createElement('i'))
      probe.style.color = 'var(--neutral)'
      return [getComputedStyle(element).fill, getComputedStyle(probe).color]
    })
    assert.equal(fill, neutral)
    await statistics.getByRole('heading', { name: 'Events on the bus' }).waitFor()
    assert.ok((await statistics.locator('ul[aria-label="Events on the bus"] li').count()) <= 20)
    await becomes(() => statistics.getByRole('button', { name: 'Make capture' }).count(), 0)
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
})

test('on a phone the statistics do not scroll sideways, and each count names its column', async () => {
  const phone = { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true }
  for (const locale of ['en-GB', 'de-DE']) {
    const { page, complaints, close } = await openPage(browser, `${station.url}/bus`, { ...phone, locale })
    try {
      const statistics = page.locator('details.statistics').first()
      await statistics.locator('summary').click()
      await statistics.locator('table.stacked tbody tr').nth(1).waitFor()
      const scrolling = await page
        .locator('html, .statistics, .statistics *')
        .evaluateAll((all) =>
          all
            .filter(
              (one) => !one.closest('svg') && one.scrollWidth > Math.max(one.clientWidth, 1) && one.clientWidth > 0,
            )
            .map((one) => `${one.tagName} ${one.className} ${one.scrollWidth} > ${one.clientWidth}`),
        )
      assert.deepEqual(scrolling, [], locale)
      assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 360, locale)
      const titles = await statistics
        .locator('table.stacked tbody tr')
        .nth(1)
        .locator('th, td')
        .evaluateAll((all) => all.map((one) => getComputedStyle(one, '::before').content))
      assert.ok(titles.length === 10 && titles.every((title) => /^"\p{L}.*"$/u.test(title)), titles.join())
      assert.deepEqual(complaints, [])
    } finally {
      await close()
    }
  }
})
