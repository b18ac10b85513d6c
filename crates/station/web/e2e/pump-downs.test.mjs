// Pump-downs over each other in a browser.

import assert from 'node:assert/strict'
import { readFile } from 'node:fs/promises'
import { after, before, test } from 'node:test'
import { becomes, openPage, startBrowser, startPlant } from './setup.mjs'

let browser
let plant

before(async () => {
  ;[browser, plant] = await Promise.all([startBrowser(), startPlant('127.0.0.1:0', 'pumped')])
})

after(async () => {
  await browser?.close()
  await plant?.stop()
})

/** Opens a page of the station. The console may show no error. */
async function visit(path, look, options = {}) {
  const { page, complaints, close } = await openPage(browser, plant.url + path, options)
  try {
    await look(page)
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
}

const PAGE = '/trends/pump-downs?series=transfer%20lock'

test('a late pump-down lies over the last ten, with its deviation in words and its times in a table', async () => {
  await visit(PAGE, async (page) => {
    await page.locator('svg polyline.shown').waitFor()
    await becomes(() => page.locator('nav [aria-current]').innerText(), 'Trends')
    await becomes(() => page.locator('svg polyline').count(), 11)
    const minor = await page.locator('.log-chart line.minor').count()
    assert.ok(minor > 0 && minor % 8 === 0, `${minor} lines for 2 to 9`)
    const verdict = await page.locator('.verdict').innerText()
    assert.match(
      verdict,
      /▲ .* later to 1\.00 × 10⁻. mbar than usual: .*the median of the last 10.*; since \w+day, \d{4}-\d\d-\d\d: the pressure above/,
    )
    assert.match(verdict, /late at low pressure only|falls as the time/)
    const row = page.locator('tr.deviates', { hasText: '1.00 × 10⁻⁵ mbar' })
    assert.match(await row.innerText(), /12 min.*▲ later.*6 min/s)
    // Colour is for alarms: a deviation is as dark as other text.
    const colours = await page
      .locator('body, .verdict.deviates, tr.deviates td')
      .evaluateAll((all) => all.map((element) => getComputedStyle(element).color))
    assert.equal(new Set(colours).size, 1, colours.join('; '))
    assert.match(await page.locator('.legend').innerText(), /━ \d{4}-\d\d-\d\d .*─ the others, as usual/s)
  })
})

test('on a phone the chart has its unit, and texts as large as those of the page', async () => {
  const phone = { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true }
  await visit(
    PAGE,
    async (page) => {
      const texts = page.locator('.log-chart text')
      await texts.first().waitFor()
      const heights = await texts.evaluateAll((all) => all.map((text) => text.getBoundingClientRect().height))
      assert.ok(Math.min(...heights) >= 10, heights.join(' '))
      assert.equal(await page.locator('.log-chart .unit').textContent(), 'mbar')
      const lines = await page
        .locator('.runs button')
        .evaluateAll((all) =>
          all.map(
            (element) =>
              element.getBoundingClientRect().height / Number.parseFloat(getComputedStyle(element).lineHeight),
          ),
        )
      assert.ok(Math.max(...lines) < 3.2, `a time takes ${Math.max(...lines)} lines`)
    },
    phone,
  )
})

test('on a phone the table of times is not wider than the page, in both languages', async () => {
  for (const locale of ['en-GB', 'de-DE']) {
    const phone = { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true, locale }
    await visit(
      PAGE,
      async (page) => {
        const table = page.locator('.pump-downs table')
        await table.waitFor()
        const { x, width } = await table.boundingBox()
        assert.ok(x + width <= 360, `the table ends at ${x + width}, ${locale}`)
        assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 360, locale)
      },
      phone,
    )
  }
})

test('another pump-down and a reference can be chosen, and stay in the address', async () => {
  await visit(PAGE, async (page) => {
    await page.locator('.runs button').nth(2).click()
    await page.locator('.verdict', { hasText: 'As usual.' }).waitFor()
    const starts = await page
      .getByLabel('Compare with')
      .locator('option')
      .evaluateAll((all) => all.map(({ value }) => value))
    await page.getByLabel('Compare with').selectOption(starts[1])
    await page.locator('.verdict', { hasText: 'earlier' }).waitFor()
    assert.match(await page.locator('.verdict').innerText(), /the chosen one/)
    assert.match(page.url(), /reference=\d+/)
    await page.reload()
    await page.locator('.verdict', { hasText: 'the chosen one' }).waitFor()
  })
})

test('the trends page links to the pump-downs of its first series', async () => {
  await visit('/trends', async (page) => {
    await page.getByRole('link', { name: 'Compare pump-downs' }).click()
    await page.getByRole('heading', { name: 'Pump-downs' }).waitFor()
    assert.match(page.url(), /pump-downs\?series=/)
  })
})

test('helium at a leak is a sentence with its size and its time', async () => {
  await visit('/trends/pump-downs?series=leaking%20chamber', async (page) => {
    const found = page.getByRole('region', { name: 'Like helium at a leak' })
    await found.waitFor()
    assert.match(await found.innerText(), /falls by .*mbar.*helium sprayed on a leak/s)
    await becomes(() => found.locator('p').count(), 1)
  })
  await visit(PAGE, async (page) => {
    await page.locator('.verdict').waitFor()
    await becomes(() => page.getByRole('region', { name: 'Like helium at a leak' }).count(), 0)
  })
})

test('the report about the chosen pump-down is downloaded', async () => {
  await visit(PAGE, async (page) => {
    const [report] = await Promise.all([
      page.waitForEvent('download'),
      page.getByRole('link', { name: 'Report about this pump-down' }).click(),
    ])
    assert.match(report.suggestedFilename(), /^pump-down-[\d-]+\.html$/)
    assert.match(await readFile(await report.path(), 'utf8'), /transfer lock/)
  })
})
