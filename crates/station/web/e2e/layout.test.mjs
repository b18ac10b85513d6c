// What a page looks like at several widths: no text is cut, lies over another text or loses its room.

import assert from 'node:assert/strict'
import { after, before, test } from 'node:test'
import { openPage, startBrowser, startPlant } from './setup.mjs'

let browser
let plant

before(async () => {
  ;[browser, plant] = await Promise.all([startBrowser(), startPlant()])
})

after(async () => {
  await browser?.close()
  await plant?.stop()
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

test('with a zoom of 200 % and on an upright tablet the text of an alarm keeps its width', async () => {
  for (const width of [660, 720, 800, 900, 1024]) {
    await visit(
      `${plant.url}/alarms`,
      async (page) => {
        await page.locator('.alarm-item').first().waitFor()
        const widths = await page
          .locator('.alarm-item .description')
          .evaluateAll((all) => all.map(({ clientWidth }) => clientWidth))
        assert.ok(widths.length > 0 && widths.every((one) => one >= 256), `${widths} at ${width}`)
        assert.ok((await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)) <= 0, `at ${width}`)
      },
      { viewport: { width, height: 900 } },
    )
  }
})

test('the longest state of an alarm does not reach into its text', async () => {
  await visit(`${plant.url}/alarms`, async (page) => {
    const item = page.locator('.alarm-item').first()
    await item.waitFor()
    const room = await item.evaluate((item) => {
      item.querySelector('.alarm-state').textContent = 'gegangen, nicht quittiert'
      const [state, text] = ['.alarm-state', '.description'].map((one) =>
        item.querySelector(one).getBoundingClientRect(),
      )
      return text.left - state.right
    })
    assert.ok(room > 0, `${room} pixels between state and text`)
  })
})

test('the marks of the help do not reach into their explanations, in both languages', async () => {
  for (const locale of ['en-GB', 'de-DE']) {
    await visit(
      plant.url,
      async (page) => {
        await page.keyboard.press('?')
        await page.locator('dialog.help').waitFor()
        const meeting = await page.locator('.help .keys > div').evaluateAll((all) =>
          all
            .filter((one) => {
              const range = document.createRange()
              range.selectNodeContents(one.querySelector('dt'))
              return range.getBoundingClientRect().right > one.querySelector('dd').getBoundingClientRect().left
            })
            .map(({ textContent }) => textContent),
        )
        assert.deepEqual(meeting, [])
      },
      { locale, viewport: { width: 1440, height: 900 } },
    )
  }
})
