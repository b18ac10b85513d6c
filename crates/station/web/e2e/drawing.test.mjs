// The user's own drawing of the plant, on a station with a gauge in memory.

import assert from 'node:assert/strict'
import { mkdtemp, rm, writeFile } from 'node:fs/promises'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after, before, test } from 'node:test'
import { violations } from './axe.mjs'
import { becomes, openPage, startBrowser, startStation } from './setup.mjs'

const LINE = 'devices = ["bcg450@5"]\npressure = "2e-4 mbar"\n'

const FILE = `
[station]
drawing = "hall.svg"

[[segment]]
name = "hall"
port = "sim:line.toml"

[[segment.gauge]]
name = "ion gauge"
address = 5
device = "bcg450"

[[alarm]]
name = "chamber not evacuated"
gauge = "ion gauge"
above = "1e-4 mbar"
delay = "0 s"
priority = "high"

[[volume]]
name = "chamber"
gauges = ["ion gauge"]

[[volume]]
name = "lock"

[[valve]]
name = "slide valve"
between = ["chamber", "lock"]
`

const DRAWING = `<?xml version="1.0"?>
<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" viewBox="0 0 600 300"
  onload="document.title = 'run'">
  <script>document.title = 'run'</script>
  <style>text { font-size: 20px } header, h1 { display: none }</style>
  <rect id="volume:chamber" x="20" y="20" width="300" height="200" style="fill:#fff;stroke:#888"/>
  <text id="gauge:ion_gauge" x="40" y="120">pressure</text>
  <path id="p1" inkscape:label="valve:slide valve" d="M320 100 h40 v40 h-40 z" stroke="#888"/>
  <image href="https://other.example/a.png"/>
</svg>`

let browser
let folder
let station

before(async () => {
  folder = await mkdtemp(join(tmpdir(), 'profivac-drawing-'))
  for (const [name, text] of Object.entries({ 'line.toml': LINE, 'hall.toml': FILE, 'hall.svg': DRAWING }))
    await writeFile(join(folder, name), text)
  ;[browser, station] = await Promise.all([startBrowser(), startStation(join(folder, 'hall.toml'))])
})

after(async () => {
  await browser?.close()
  await station?.stop()
  await rm(folder, { recursive: true, force: true })
})

async function visit(path, look, options = {}) {
  const { page, complaints, close } = await openPage(browser, station.url + path, options)
  try {
    await look(page)
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
}

const pressure = (page) => page.locator('.own-drawing text[data-gauge="ion gauge"]')

test('the drawing has live pressures, shades, states and alarms', async () => {
  await visit('/plant', async (page) => {
    await pressure(page)
      .getByText(/^2(\.\d+)? × 10⁻⁴ mbar$/)
      .waitFor()
    const chamber = page.locator('.own-drawing [data-volume="chamber"]')
    await page.locator('.own-drawing [data-volume="chamber"][data-alarm="high"]').waitFor()
    assert.match(await chamber.getAttribute('aria-label'), /^chamber: 2.* mbar, alarms: 1 high$/)
    assert.match(await chamber.getAttribute('style'), /--shade: \d+%/)
    assert.notEqual(await chamber.evaluate((rect) => getComputedStyle(rect).fill), 'rgb(255, 255, 255)')
    const valve = page.locator('.own-drawing [data-part="slide valve"]')
    await becomes(() => valve.getAttribute('aria-label'), 'slide valve: valve, not reported')
    await page.keyboard.press('u')
    await pressure(page)
      .getByText(/× 10⁻⁴ hPa$/)
      .waitFor()
  })
})

test('a gauge of the drawing leads to its page, by mouse and by key', async () => {
  await visit('/plant', async (page) => {
    await pressure(page).getByText(/mbar$/).waitFor()
    await pressure(page).click()
    await page.locator('h2', { hasText: 'ion gauge' }).waitFor()
  })
  await visit('/', async (page) => {
    await pressure(page).getByText(/mbar$/).waitFor()
    await pressure(page).focus()
    await page.keyboard.press('Enter')
    await page.locator('h2', { hasText: 'ion gauge' }).waitFor()
  })
})

test('nothing of the drawing runs, is fetched, or reaches the rest of the page', async () => {
  await visit('/plant', async (page) => {
    await pressure(page).getByText(/mbar$/).waitFor()
    await becomes(() => page.locator('.own-drawing :is(script, image)').count(), 0)
    assert.doesNotMatch(await page.title(), /run/)
    await becomes(() => page.locator('header').isVisible(), true)
    assert.equal(await pressure(page).evaluate((text) => getComputedStyle(text).fontSize), '20px')
  })
})

test('a drawing for white paper has a white sheet in the dark theme, and can be read on a phone', async () => {
  await visit(
    '/plant',
    async (page) => {
      await pressure(page).getByText(/mbar$/).waitFor()
      const drawing = page.locator('[data-sheet]')
      assert.equal(await drawing.evaluate((sheet) => getComputedStyle(sheet).backgroundColor), 'rgb(255, 255, 255)')
      const height = await pressure(page).evaluate((text) => 20 * text.getCTM().a)
      assert.ok(height >= 10.9, `letters of ${height} pixels`)
    },
    { colorScheme: 'dark', viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true },
  )
})

test('the drawing fits a phone, and axe finds nothing', async () => {
  for (const colorScheme of ['light', 'dark']) {
    await visit(
      '/plant',
      async (page) => {
        await pressure(page).getByText(/mbar$/).waitFor()
        const [needed, width] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth])
        assert.ok(needed <= width, `${needed} of ${width} pixels`)
        assert.deepEqual(await violations(page), [], colorScheme)
      },
      { colorScheme, viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true },
    )
  }
})
