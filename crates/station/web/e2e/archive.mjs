// The page of an archive in a browser. contrib/archive/view starts stations and an archive, and names its address in ARCHIVE.

import assert from 'node:assert/strict'
import { after, before, test } from 'node:test'
import { openPage, startBrowser } from './setup.mjs'

const { ARCHIVE, PICTURES } = process.env

let browser

before(async () => {
  browser = await startBrowser()
})

after(async () => {
  await browser?.close()
})

/** Opens a page of the archive. The console may show no error. */
async function visit(path, look, options = {}) {
  const { page, complaints, close } = await openPage(browser, ARCHIVE + path, options)
  try {
    await look(page)
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
}

const PHONE = { viewport: { width: 320, height: 640 }, isMobile: true, hasTouch: true }

test('problems come first, then each station with its readings', async () => {
  await visit('/', async (page) => {
    const chamber = page.locator('[data-series="station-0/chamber"]')
    await chamber.getByText(/mbar/).first().waitFor()
    assert.match(await chamber.innerText(), /×\s10⁻[³⁴]\s*mbar/)
    const problem = page.locator('.problems [data-station="station-1"]')
    assert.match(await problem.innerText(), /1\shigh\s+not acknowledged/)
    assert.match(await page.getByRole('banner').innerText(), /2 alarms, 2 not acknowledged/)
    assert.deepEqual(await page.locator('section.segment h2').allInnerTexts(), ['Problems', 'station-0', 'station-1'])
    if (PICTURES) await page.screenshot({ path: `${PICTURES}/archive-stations.png` })
  })
})

test('search and plant choose the stations', async () => {
  await visit('/', async (page) => {
    await page.getByLabel('Plant').selectOption('ring')
    await page.getByText('1 of 2 stations').waitFor()
    await page.getByLabel('Plant').selectOption('')
    await page.getByLabel('Search stations and gauges').fill('station-0 fore')
    await page.getByText('1 of 2 stations').waitFor()
    assert.equal(await page.locator('section[data-station] [data-series]').count(), 1)
    await page.getByLabel('Search stations and gauges').fill('nothing')
    await page.getByText('No station and no gauge matches.').waitFor()
  })
})

test('a reading leads to its trend, and other stations are added to it', async () => {
  await visit('/', async (page) => {
    await page.locator('[data-series="station-0/chamber"]').getByRole('link').click()
    await page.waitForFunction(() => Number(document.querySelector('.chart')?.dataset.points) > 0)
    await page.getByRole('checkbox', { name: 'station-1/foreline' }).check()
    await page.waitForFunction(() => new URLSearchParams(location.search).getAll('s').length === 2)
    await page.locator('.chart-table summary').click()
    const heads = page.locator('.chart-table th[scope=col]')
    await heads.first().waitFor()
    assert.deepEqual(await heads.allInnerTexts(), ['Time', 'station-0/chamber', 'station-1/foreline'])
    if (PICTURES) await page.screenshot({ path: `${PICTURES}/archive-trends.png` })
  })
})

test('alarms and events name their stations', async () => {
  await visit('/alarms', async (page) => {
    const rows = page.getByRole('row').filter({ hasText: 'chamber too high' })
    await rows.nth(1).waitFor()
    assert.match(await rows.first().innerText(), /station-[01]/)
  })
  await visit('/events', async (page) => {
    await page.getByLabel('Station').selectOption('station-1')
    await page.getByRole('cell', { name: 'station-1', exact: true }).first().waitFor()
    await page.waitForFunction(() => {
      const stations = [...document.querySelectorAll('tbody tr td:nth-child(2)')].map((cell) => cell.textContent)
      return stations.length > 0 && stations.every((station) => station === 'station-1')
    })
  })
})

test('a phone shows all pages without scrolling sideways', async () => {
  for (const path of ['/', '/trends', '/alarms', '/events']) {
    await visit(
      path,
      async (page) => {
        await page.locator('main h1').first().waitFor({ state: 'attached' })
        const [needed, width] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth])
        assert.ok(needed <= 320 && width === 320, `${path} needs ${needed} of ${width} pixels`)
        if (PICTURES) await page.screenshot({ path: `${PICTURES}/archive-phone${path.replace('/', '-')}.png` })
      },
      PHONE,
    )
  }
})

test('a page that does not exist says so', async () => {
  await visit('/nowhere', async (page) => {
    await page.getByRole('link', { name: 'Go to the stations' }).click()
    await page.locator('[data-station="station-0"]').first().waitFor()
  })
})
