// A plant identified from its record in a browser.

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

const PAGE = '/rise/identify?series=test%20chamber'

/** Enters the volume and waits for the numbers. */
async function identify(page) {
  await page.getByRole('spinbutton', { name: 'Volume L' }).fill('50')
  await page.getByRole('button', { name: 'Identify' }).click()
  await page.getByRole('heading', { name: 'The fit describes the record' }).waitFor()
}

/** The numbers of a text such as `2.00 × 10⁻⁶ mbar L/s`. */
function numbersIn(text) {
  const digits = (power) => [...power].map((sign) => '⁰¹²³⁴⁵⁶⁷⁸⁹'.indexOf(sign)).join('')
  const found = text.matchAll(/([\d.]+)(?:\s×\s10(⁻?)([⁰¹²³⁴⁵⁶⁷⁸⁹]+))?/g)
  return [...found].map(([, number, minus, power]) =>
    power ? Number(`${number}e${minus ? '-' : ''}${digits(power)}`) : Number(number),
  )
}

test('a plant is identified, with intervals, residuals, a prediction with its band, and what would help', async () => {
  await visit(PAGE, async (page) => {
    await page.locator('form', { hasText: 'Enter the volume, or a dose and its time' }).waitFor()
    assert.ok(await page.getByRole('button', { name: 'Identify' }).isDisabled())
    await page.getByLabel('Target pressure').fill('5e-7')
    await identify(page)
    // The truth of the station's plant: 20 L/s, 2e-6 and 2e-5 mbar L/s.
    for (const [name, truth] of [
      [/^leak/, 2e-6],
      [/^outgassing after 1\sh/, 2e-5],
      [/^exponent of outgassing/, 1],
    ]) {
      const row = page.locator('tbody tr', { has: page.locator('th', { hasText: name }) })
      const [low, high] = numbersIn(await row.locator('td').nth(1).innerText())
      assert.ok(low <= truth && truth <= high, `${name}: ${low} to ${high} without ${truth}`)
    }
    assert.equal(await page.locator('.log-chart .unit').textContent(), 'mbar')
    const exponent = page.locator('tbody tr', { hasText: 'exponent of outgassing' })
    assert.match(await exponent.locator('td').nth(1).innerText(), /^[01]\.\d+ to [01]\.\d+$/)
    const pump = page.locator('tbody tr', { hasText: 'ultimate pressure of the pump' })
    assert.match(await pump.innerText(), /cannot be told from zero/)
    assert.ok((await page.locator('svg').first().locator('circle.measured').count()) > 100)
    for (const part of ['polyline.fit', 'polyline.predicted', 'polygon.band']) {
      assert.match(await page.locator(`svg ${part}`).first().getAttribute('points'), /^[\d.]+,[\d.]+ /)
    }
    assert.ok((await page.locator('svg').nth(1).locator('circle').count()) > 100)
    const [report] = await Promise.all([
      page.waitForEvent('download'),
      page.getByRole('link', { name: 'Report about this pump-down' }).click(),
    ])
    assert.match(report.suggestedFilename(), /^pump-down-[\d-]+\.html$/)
    assert.match(await readFile(await report.path(), 'utf8'), /<h2>Plant<\/h2>/)
    assert.match(await page.locator('.facts').innerText(), /5e-7 mbar is reached after\s+\S+/)
    assert.match(await page.locator('.remedies li').first().innerText(), /: [\d.]+ \([\d.]+ to [\d.]+\)/)
  })
})

test('a change of the volume takes the result away, and the address keeps it', async () => {
  await visit(PAGE, async (page) => {
    await identify(page)
    await page.getByRole('spinbutton', { name: 'Volume L' }).fill('60')
    await page.getByRole('heading', { name: 'The fit describes the record' }).waitFor({ state: 'detached' })
    await page.reload()
    await becomes(() => page.getByRole('spinbutton', { name: 'Volume L' }).inputValue(), '60')
  })
})

test('a time that is being typed stays when the page is drawn again', async () => {
  await visit(PAGE, async (page) => {
    await page.locator('summary').click()
    const end = page.getByLabel('End of the record')
    await end.fill('2026-05-01 12:')
    // Another field changes without taking the focus, as a new pressure does.
    await page.getByRole('spinbutton', { name: 'Volume L' }).evaluate((field) => {
      field.value = '60'
      field.dispatchEvent(new Event('input', { bubbles: true }))
    })
    await page.waitForFunction(() => new URLSearchParams(location.search).get('litres') === '60')
    await page.evaluate(() => new Promise(requestAnimationFrame))
    await becomes(() => end.inputValue(), '2026-05-01 12:')
    await end.pressSequentially('30:00')
    await end.press('Tab')
    await page.waitForFunction(() => new URLSearchParams(location.search).get('to') === '2026-05-01 12:30:00')
  })
})

test('a record that cannot be fitted says why', async () => {
  const open = []
  const { page, close } = await openPage(browser, plant.url + PAGE)
  try {
    page.on('response', (answer) => answer.url().includes('/api/identify') && open.push(answer.status()))
    await page.getByRole('spinbutton', { name: 'Volume L' }).fill('50')
    await page.locator('summary').click()
    // Until the pump-downs are found, the choice has an option without a time.
    const found = page.getByRole('combobox', { name: 'Pump-down' }).locator('option:checked', { hasText: /^\d{4}-/ })
    const start = await found.textContent()
    const end = new Date(Date.parse(start.replace(' ', 'T')) + 10_000)
    const two = (number) => String(number).padStart(2, '0')
    const day = `${end.getFullYear()}-${two(end.getMonth() + 1)}-${two(end.getDate())}`
    const text = `${day} ${two(end.getHours())}:${two(end.getMinutes())}:${two(end.getSeconds())}`
    await page.getByLabel('End of the record').fill(text)
    await page.getByLabel('End of the record').press('Tab')
    await page.waitForFunction(() => new URLSearchParams(location.search).has('to'))
    await page.getByRole('button', { name: 'Identify' }).click()
    await page.locator('.error').waitFor()
    assert.match(await page.locator('.error').innerText(), /expected at least 30 samples/)
    assert.deepEqual(open, [400])
  } finally {
    await close()
  }
})

test('a phone shows the result without scrolling sideways', async () => {
  await visit(
    PAGE,
    async (page) => {
      await identify(page)
      const [needed, width] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth])
      assert.ok(needed <= 320 && width === 320, `the page needs ${needed} of ${width} pixels`)
    },
    { viewport: { width: 320, height: 640 }, isMobile: true, hasTouch: true },
  )
})

test('the pages about rises and pump-downs link to it', async () => {
  for (const path of ['/rise?s=vessel', '/trends/pump-downs?series=transfer%20lock']) {
    await visit(path, async (page) => {
      await page.getByRole('link', { name: 'Identify the plant' }).click()
      await page.getByRole('heading', { name: 'Plant from its record' }).waitFor()
      await becomes(() => page.locator('nav [aria-current]').innerText(), 'Rate of rise')
    })
  }
})
