// Trends in a browser: values beside a reference, the lane of events, the picture as a file.

import assert from 'node:assert/strict'
import { readFile } from 'node:fs/promises'
import { after, before, test } from 'node:test'
import { becomes, drawn, openPage, startBrowser, startPlant } from './setup.mjs'

let browser
let plant
let window

before(async () => {
  ;[browser, plant] = await Promise.all([startBrowser(), startPlant()])
  const { started_ms } = await plant.json('/api/station')
  window = `from=${started_ms - 900_000}&to=${started_ms}`
})

after(async () => {
  await browser?.close()
  await plant?.stop()
})

/** Opens the trends of two series that are recorded for a quarter of an hour. */
async function visit(look, query = '', options = {}) {
  const { page, complaints, close } = await openPage(
    browser,
    `${plant.url}/trends?s=detector&s=turbo+outlet&${window}${query}`,
    options,
  )
  try {
    await drawn(page)
    await look(page)
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
}

const differenceOf = (page, series) => page.locator('.series-list li', { hasText: series }).locator('.difference')

test('a press in the chart sets a reference, and the list compares the cursor with it', async () => {
  await visit(async (page) => {
    await page.getByText('Press in the chart to set a reference').waitFor()
    const over = await page.locator('.chart .u-over').boundingBox()
    const at = (part) => [over.x + over.width * part, over.y + over.height / 2]
    await page.mouse.click(...at(0.1))
    await page.locator('.reference strong', { hasText: /^Reference \d{4}-/ }).waitFor()
    await page.mouse.move(...at(0.9))
    // Its pressure does not change.
    const difference = differenceOf(page, 'turbo outlet').filter({ hasText: '× 1' })
    await difference.waitFor()
    const parts = await difference.locator('> div').allTextContents()
    assert.deepEqual(parts, ['Ratio× 1 ', 'Difference0 mbar', 'Slope0 decades/min', 'Slope0 mbar/min'])
    await page.getByText(/the values are 1[12] min( \d+ s)? after it/).waitFor()
    const { searchParams } = new URL(page.url())
    assert.ok(Number(searchParams.get('reference')) > Number(searchParams.get('from')))
    await page.reload()
    await page.locator('.reference strong', { hasText: /^Reference \d{4}-/ }).waitFor()
    await page.getByRole('button', { name: 'Remove reference' }).click()
    await page.getByText('Press in the chart to set a reference').waitFor()
    assert.equal(new URL(page.url()).searchParams.has('reference'), false)
  })
})

test('a chart that is held goes on with the time at a press, and is held again at the next', async () => {
  await visit(async (page) => {
    const parameters = () => [...new URL(page.url()).searchParams.keys()].filter((key) => /^(range|from|to)$/.test(key))
    await page.getByRole('button', { name: 'Held', exact: true }).click()
    await becomes(parameters, ['range'])
    await page.getByRole('button', { name: 'Live', exact: true }).click()
    await becomes(parameters, ['from', 'to'])
    await page.getByRole('button', { name: 'Held', exact: true }).waitFor()
  })
})

test('a drag chooses a window and sets no reference', async () => {
  await visit(async (page) => {
    const over = await page.locator('.chart .u-over').boundingBox()
    const before = page.url()
    await page.mouse.move(over.x + over.width * 0.3, over.y + 60)
    await page.mouse.down()
    await page.mouse.move(over.x + over.width * 0.6, over.y + 70, { steps: 4 })
    await page.mouse.up()
    await page.waitForURL((url) => url.href !== before)
    assert.equal(new URL(page.url()).searchParams.has('reference'), false)
  })
})

test('the keyboard moves the cursor and sets the reference', async () => {
  await visit(async (page) => {
    await page.locator('.chart').focus()
    await page.keyboard.press('Shift+ArrowLeft')
    await page.locator('.cursor-time strong', { hasText: ':' }).waitFor()
    await page.keyboard.press('r')
    await page.locator('.reference strong', { hasText: /^Reference \d{4}-/ }).waitFor()
    for (let step = 0; step < 5; step += 1) await page.keyboard.press('Shift+ArrowRight')
    await page.getByText(/the values are (\d+ s|1 min( \d+ s)?) after it/).waitFor()
    await differenceOf(page, 'turbo outlet').filter({ hasText: '× 1' }).waitFor()
  })
})

test('a reference outside the window is still compared', async () => {
  const to = Number(new URLSearchParams(window).get('to'))
  await visit(
    async (page) => {
      const over = await page.locator('.chart .u-over').boundingBox()
      await page.mouse.move(over.x + over.width / 2, over.y + 50)
      await page.getByText(/before it$/).waitFor()
      await differenceOf(page, 'turbo outlet').filter({ hasText: '× 1' }).waitFor()
    },
    `&reference=${to + 1_000}`,
  )
})

test('events lie in one lane below the chart, and a mark lists its events', async () => {
  await visit(async (page) => {
    const lane = page.getByRole('region', { name: 'Events in this window' })
    const mark = lane.getByRole('button').first()
    await mark.click()
    await lane.locator('li').first().waitFor()
    assert.match(await lane.locator('li').first().innerText(), /^\d{4}-\d\d-\d\d \d\d:\d\d:\d\d \S/)
    const [marks, chart] = await Promise.all([mark.boundingBox(), page.locator('.chart').boundingBox()])
    assert.ok(marks.y >= chart.y + chart.height - 1, 'the lane is below the chart')
    await mark.click()
    await lane.locator('li').first().waitFor({ state: 'detached' })
  })
})

test('the chart is saved as a picture', async () => {
  await visit(async (page) => {
    const [download] = await Promise.all([
      page.waitForEvent('download'),
      page.getByRole('button', { name: 'Save as PNG' }).click(),
    ])
    assert.match(download.suggestedFilename(), /^pressures \d{4}-\d\d-\d\d\.png$/)
    const octets = await readFile(await download.path())
    assert.equal(octets.subarray(1, 4).toString(), 'PNG')
    const [width, height] = [octets.readUInt32BE(16), octets.readUInt32BE(20)]
    const chart = await page.locator('.chart canvas').evaluate(({ width, height }) => ({ width, height }))
    assert.ok(width > chart.width && height > chart.height + 60, 'the picture has the chart, a title and the curves')
  })
})

test('the samples of the window are saved as CSV and as Parquet', async () => {
  await visit(async (page) => {
    const saved = async (name) => {
      const [download] = await Promise.all([page.waitForEvent('download'), page.getByRole('link', { name }).click()])
      return readFile(await download.path())
    }
    assert.match((await saved('Save as CSV')).toString(), /^time,gauge,pressure_pa,quality\n.*,detector,/)
    const octets = await saved('Save as Parquet')
    assert.deepEqual([octets.subarray(0, 4).toString(), octets.subarray(-4).toString()], ['PAR1', 'PAR1'])
  })
})

test('the page fits on a phone', async () => {
  await visit(
    async (page) => {
      await page.getByText('Press in the chart to set a reference').waitFor()
      assert.ok((await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)) <= 0)
    },
    '',
    { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true },
  )
})

test('an operator makes a note about the reference, and it is an event of the chart and of the list', async () => {
  await visit(async (page) => {
    const over = await page.locator('.chart .u-over').boundingBox()
    await page.mouse.click(over.x + over.width * 0.97, over.y + over.height / 2)
    await page.getByRole('button', { name: 'Make a note' }).click()
    const dialog = page.getByRole('dialog', { name: 'Make a note' })
    await dialog.getByLabel('Text').fill('the trap is filled')
    await dialog.getByRole('button', { name: 'Make the note' }).click()
    await dialog.waitFor({ state: 'detached' })
    const mark = page.getByRole('region', { name: 'Events in this window' }).getByRole('button', { name: /the trap/ })
    await mark.waitFor()
    await page.getByRole('link', { name: 'Events' }).click()
    const row = page.locator('.events tbody tr', { hasText: 'noted: the trap is filled' })
    await row.locator('.kind.note').waitFor()
  })
})

test('the time without a gauge is a bar in the colour of the curve', async () => {
  const gauges = await plant.json('/api/gauges')
  const { series } = gauges.flatMap(({ readings }) => readings).find(({ quality }) => quality === 'missing')
  const { page, close } = await openPage(browser, `${plant.url}/trends?range=1m&s=${encodeURIComponent(series)}`)
  try {
    await drawn(page)
    const count = await page.evaluate(() => {
      const { height, width } = document.querySelector('.chart canvas')
      const swatch = document.querySelector('.series-list li:not(.off) .swatch')
      const wanted = getComputedStyle(swatch).backgroundColor.match(/\d+/g).map(Number)
      const { data } = document.querySelector('.chart canvas').getContext('2d').getImageData(0, 0, width, height)
      let found = 0
      for (let at = 0; at < data.length; at += 4)
        if (wanted.every((part, index) => Math.abs(data[at + index] - part) < 40)) found += 1
      return found
    })
    assert.ok(count > 40, `${count} pixels`)
  } finally {
    await close()
  }
})
