// The page of an archive in a browser. contrib/archive/view.py starts stations and archives, and names their addresses: ARCHIVE without users, ARCHIVE_USERS
// with the operator ada. PICTURES is a folder for the picture of docs/archive.md. The alarm of station-0 is acknowledged, that of station-1 is not.

import assert from 'node:assert/strict'
import { after, before, test } from 'node:test'
import { violations } from './axe.mjs'
import { check } from './german.mjs'
import { becomes, openContext, openPage, startBrowser } from './setup.mjs'

const { ARCHIVE, ARCHIVE_USERS, PASSWORD, PICTURES } = process.env

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
    assert.match(await chamber.innerText(), /×\s10⁻[²³]\s*mbar/)
    const problem = page.locator('.problems [data-station="station-1"]')
    assert.match(await problem.innerText(), /1\shigh\s+not acknowledged/)
    assert.match(await page.getByRole('banner').innerText(), /2 active alarms, 1 not acknowledged/)
    await becomes(() => page.locator('section.segment h2').allInnerTexts(), ['Problems', 'station-0', 'station-1'])
    // The picture of docs/archive.md.
    if (PICTURES) {
      const { y, height } = await page.locator('section[data-station="station-1"]').boundingBox()
      await page.screenshot({ path: `${PICTURES}/archive.png`, clip: { x: 0, y: 0, width: 1280, height: y + height } })
    }
  })
})

test('search and plant choose the stations', async () => {
  await visit('/', async (page) => {
    await page.getByLabel('Plant').selectOption('ring')
    await page.getByText('1 of 2 stations').waitFor()
    await page.getByLabel('Plant').selectOption('')
    await page.getByLabel('Search stations and gauges').fill('station-0 fore')
    await page.getByText('1 of 2 stations').waitFor()
    await becomes(() => page.locator('section[data-station] [data-series]').count(), 1)
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
    await becomes(() => heads.allInnerTexts(), ['Time', 'station-0/chamber', 'station-1/foreline'])
    const asked = page.waitForResponse((answer) => answer.url().includes('full=true'))
    await page.getByRole('button', { name: 'Full resolution' }).click()
    assert.equal((await asked).status(), 200)
  })
})

test('points of a slave have charts with their units, and their values at the cursor', async () => {
  await visit('/trends?range=1h&s=station-0%2Fchamber', async (page) => {
    const list = page.getByRole('group', { name: 'Points of slaves' })
    const charts = page.locator('.trend-chart + .trend-chart .chart')
    await list.getByLabel('station-0/turbo.speed').check()
    await list.getByLabel('station-0/turbo.state').check()
    await charts.nth(1).waitFor()
    await page.waitForFunction(() => {
      const all = [...document.querySelectorAll('.trend-chart + .trend-chart .chart')]
      return all.length === 2 && all.every((chart) => Number(chart.dataset.points) > 0)
    })
    assert.deepEqual(await charts.evaluateAll((all) => all.map((chart) => chart.dataset.unit)), ['Hz', ''])
    assert.deepEqual(new URL(page.url()).searchParams.getAll('p'), ['station-0/turbo.speed', 'station-0/turbo.state'])
    // Five minutes ago: the spans of the last 20 minutes end two minutes ago at the latest.
    const plot = await charts.nth(0).locator('.u-over').boundingBox()
    await page.mouse.move(plot.x + (plot.width * 55) / 60, plot.y + plot.height / 2)
    await list.getByText('3 Hz').waitFor()
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

test('an operator logs in and acknowledges an alarm of a station', async () => {
  const { page, complaints, close } = await openContext(browser)
  try {
    await page.goto(`${ARCHIVE_USERS}/alarms`)
    await page.getByLabel('Name').fill('ada')
    await page.getByLabel('Password', { exact: true }).fill(PASSWORD)
    await page.getByRole('button', { name: 'Log in' }).click()
    const row = page.getByRole('row').filter({ hasText: 'station-1' })
    await row.getByRole('button', { name: 'Acknowledge' }).click()
    await row.getByText('(archive:ada)').waitFor()
    await row.getByRole('button', { name: 'Acknowledge' }).waitFor({ state: 'detached' })
    assert.match(await page.getByRole('banner').innerText(), /2 active alarms/)
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
})

test('axe finds nothing on any page', async () => {
  for (const colorScheme of ['light', 'dark']) {
    for (const path of ['/', '/trends?s=station-0%2Fchamber&p=station-0%2Fturbo.speed', '/alarms', '/events']) {
      await visit(
        path,
        async (page) => {
          await page.locator('main h1').waitFor()
          assert.deepEqual(await violations(page), [], `${path}, ${colorScheme}`)
        },
        { colorScheme },
      )
    }
  }
})

test('a German browser shows all pages in German', async () => {
  const pages = {
    '/': 'Stationen',
    '/trends?s=station-0%2Fchamber': 'Verlauf',
    '/alarms': 'Alarme',
    '/events': 'Ereignisse',
  }
  for (const [path, heading] of Object.entries(pages)) {
    await visit(
      path,
      async (page) => {
        await page.getByRole('heading', { level: 1, name: heading }).waitFor({ state: 'attached' })
        await check(page, path)
      },
      { locale: 'de-DE' },
    )
  }
  await visit(
    '/nowhere',
    async (page) => {
      await page.getByRole('link', { name: 'Zu den Stationen' }).waitFor()
      await page.getByRole('button', { name: 'English' }).click()
      await page.getByRole('link', { name: 'Go to the stations' }).waitFor()
      await page.waitForFunction(() => document.title === 'Page not found · archive')
    },
    { locale: 'de-DE' },
  )
})
