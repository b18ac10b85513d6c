// The wall display: large values without controls, the problems first.

import assert from 'node:assert/strict'
import { after, before, test } from 'node:test'
import { openContext, openPage, startBrowser, startPlant } from './setup.mjs'

let browser
let large

before(async () => {
  ;[browser, large] = await Promise.all([startBrowser(), startPlant('127.0.0.1:0', 'large')])
})

after(async () => {
  await browser?.close()
  await large?.stop()
})

async function openWall(url, options = {}) {
  const opened = await openContext(browser, { viewport: { width: 1920, height: 1080 }, ...options })
  await opened.page.goto(url)
  await opened.page.locator('.wall-tile').first().waitFor()
  return opened
}

const series = (page) => page.locator('.wall-tile').evaluateAll((tiles) => tiles.map(({ dataset }) => dataset.series))

test('480 gauges turn in pages, the problems stay, and nothing is a control or is cut off', async () => {
  const { page, complaints, close } = await openWall(`${large.url}/wall`)
  try {
    await page
      .locator('.wall-page')
      .getByText(/^page \d+ of \d+$/)
      .waitFor()
    const first = await series(page)
    assert.equal(first[0], 'gate 2')
    assert.equal(await page.locator('a, button, input, select, summary, [tabindex="0"]').count(), 0)
    const cut = await page.evaluate(() => {
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
    assert.deepEqual(cut, [false, 0, 0, 0])
    await page.waitForFunction(
      (last) => ![...document.querySelectorAll('.wall-tile')].some(({ dataset }) => dataset.series === last),
      first.at(-1),
    )
    const second = await series(page)
    assert.equal(second[0], 'gate 2')
    assert.deepEqual(complaints, [])
  } finally {
    await close()
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
    assert.equal(await page.locator('.wall-page').count(), 0)
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
    assert.equal(await page.getByRole('alert').count(), 0)
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
