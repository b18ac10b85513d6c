// What a page looks like at several widths: no text is cut, lies over another text or loses its room.

import assert from 'node:assert/strict'
import { after, before, test } from 'node:test'
import { becomes, openContext, openPage, startBrowser, startLastingDemo, startPlant } from './setup.mjs'

let browser
let plant
let large
let demo

const PHONE = { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true }

before(async () => {
  ;[browser, plant, large, demo] = await Promise.all([
    startBrowser(),
    startPlant(),
    startPlant('127.0.0.1:0', 'large'),
    startLastingDemo('--speed', '3'),
  ])
})

after(async () => {
  await browser?.close()
  await Promise.all([plant?.stop(), large?.stop(), demo?.stop()])
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

/** The texts of elements that are wider than the room of their parents. */
const tooWide = (page, selector) =>
  page.locator(selector).evaluateAll((all) =>
    all
      .filter((one) => {
        const range = document.createRange()
        range.selectNodeContents(one)
        const room = one.parentElement.getBoundingClientRect()
        const text = range.getBoundingClientRect()
        return text.right > room.right + 1 || text.left < room.left - 1
      })
      .map(({ textContent }) => textContent),
  )

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

test('each pressure of a gauge with several readings stays in its column, in the longest unit', async () => {
  await visit(
    `${demo.url}/gauge/img400%2016`,
    async (page) => {
      await page.getByLabel('Unit of pressure').selectOption('micron')
      await page.locator('.readings .underrange .unit', { hasText: 'micron' }).first().waitFor()
      for (const width of [360, 720, 1024, 1440, 1920]) {
        await page.setViewportSize({ width, height: 900 })
        assert.deepEqual(await tooWide(page, '.readings-list .big'), [], `at ${width}`)
      }
    },
    { viewport: { width: 1440, height: 900 } },
  )
})

test('the wall display shows the end of a range with its unit, and the word', async () => {
  const { page, close } = await openContext(browser, { viewport: { width: 1920, height: 1080 } })
  try {
    await page.goto(`${demo.url}/wall`)
    const under = page.locator('.wall-tile:has(.underrange)', { hasText: 'under range' })
    await under.first().waitFor()
    const cut = await page
      .locator('.wall-value')
      .evaluateAll((all) =>
        all.filter((one) => one.scrollWidth > one.clientWidth).map(({ textContent }) => textContent),
      )
    assert.deepEqual(cut, [])
  } finally {
    await close()
  }
})

test('no text of the picture of the plant is smaller than 12 pixels, and every text of a volume is inside it', async () => {
  await visit(`${demo.url}/plant`, async (page) => {
    const sizes = async () =>
      // The number in the shape of an alarm is a sign.
      page.locator('.plant-picture text:not(.alarm-shape text)').evaluateAll((all) =>
        all
          .filter(({ textContent }) => textContent !== '')
          .map((text) => {
            const scale = text.getScreenCTM().a
            return scale * Number.parseFloat(getComputedStyle(text).fontSize)
          }),
      )
    for (const width of [320, 360, 720, 1024, 1440, 1920]) {
      await page.setViewportSize({ width, height: 900 })
      const direction = width < 1400 ? 'top' : 'left'
      await page.waitForFunction((direction) => {
        const [first, second] = ['chamber', 'throat'].map((name) => {
          return document.querySelector(`.plant-picture [data-volume="${name}"]`)?.getBoundingClientRect()
        })
        return first && second[direction] > (direction === 'top' ? first.bottom : first.right)
      }, direction)
      const found = await sizes()
      assert.ok(found.length > 10 && found.every((size) => size >= 12), `${Math.min(...found)} pixels at ${width}`)
      assert.ok((await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)) <= 0, `at ${width}`)
      const outside = await page.locator('.plant-picture [data-volume]').evaluateAll((all) =>
        all.flatMap((one) => {
          const edge = one.querySelector('.volume-edge').getBoundingClientRect()
          const isOutside = (box) => box.right > edge.right || box.bottom > edge.bottom
          return [...one.querySelectorAll('text')]
            .filter((text) => isOutside(text.getBoundingClientRect()))
            .map(({ textContent }) => textContent)
        }),
      )
      assert.deepEqual(outside, [])
    }
  })
})

/** The right edges of elements, one text for each; equal ones stand below each other. */
const rightEdges = (all) => all.map((one) => Math.round(one.getBoundingClientRect().right))

test('each reading of a row has its channel and a line of its own, and the segment says where its other gauges are', async () => {
  await visit(large.url, async (page) => {
    const segment = page.getByRole('region', { name: 'Segment beam line' })
    await segment.getByText('6 gauges, 2 of them under Problems').click()
    const readings = segment.locator('[data-gauge="pump stand"] [data-series]')
    assert.deepEqual(
      (await readings.allInnerTexts()).map((text) => text.slice(0, 9)),
      ['channel 1', 'channel 2', 'channel 3', 'channel 4'],
    )
    const boxes = await readings.evaluateAll((all) => all.map((one) => one.getBoundingClientRect().toJSON()))
    for (const [index, { top }] of boxes.entries()) assert.ok(index === 0 || top >= boxes[index - 1].bottom)
    const other = segment.locator('[data-gauge="gate 1"] [data-series]')
    const ends = await Promise.all([readings, other].map(async (one) => (await one.evaluateAll(rightEdges))[0]))
    const rows = await segment
      .locator('[data-gauge="pump stand"], [data-gauge="gate 1"]')
      .evaluateAll((all) => all.map((one) => Math.round(one.getBoundingClientRect().right)).reverse())
    assert.equal(rows[0] - ends[0], rows[1] - ends[1], 'the pressures of both rows end below each other')
  })
})

test('in a card of a controller the channel is left of its pressure, in one line, and digits of one decade are aligned', async () => {
  await visit(demo.url, async (page) => {
    for (const width of [360, 1440]) {
      await page.setViewportSize({ width, height: 900 })
      const card = page.locator('.card[data-gauge="img400 16"]')
      await card.locator('.card-reading').first().waitFor()
      const lines = await card.locator('.card-reading').evaluateAll((all) =>
        all.map((one) => {
          const [label, value] = ['.reading-channel', '.big'].map((name) =>
            one.querySelector(name).getBoundingClientRect(),
          )
          return label.right <= value.left && label.top < value.bottom && value.top < label.bottom
        }),
      )
      assert.deepEqual(lines, [true, true, true, true], `at ${width}`)
    }
  })
  await visit(plant.url, async (page) => {
    const mantissas = page.locator('.card[data-gauge="pump stand"] .mantissa')
    await mantissas.filter({ hasText: '101' }).waitFor()
    const ends = await mantissas.evaluateAll((all) =>
      all.map((one) => {
        const range = document.createRange()
        range.selectNodeContents(one.firstChild)
        return range.getBoundingClientRect().right
      }),
    )
    assert.ok(ends.length >= 3 && Math.max(...ends) - Math.min(...ends) < 1, `the digits end at ${ends}`)
  })
})

test('the names of commands are readable without control, in light and dark', async () => {
  for (const colorScheme of ['light', 'dark']) {
    await visit(
      `${plant.url}/gauge/chamber`,
      async (page) => {
        const button = page.locator('.commands li button:disabled').first()
        await button.waitFor()
        const [opacity, colour, muted] = await button.evaluate((one) => {
          const { opacity, color } = getComputedStyle(one)
          return [opacity, color, getComputedStyle(document.querySelector('.command-facts .muted')).color]
        })
        assert.deepEqual([opacity, colour], ['1', muted])
      },
      { colorScheme },
    )
  }
})

test('on a phone a menu has control, unit, language and theme, and the first pressure begins in the upper half of the page', async () => {
  await visit(
    plant.url,
    async (page) => {
      const pressure = await page.locator('.card .big').first().boundingBox()
      assert.ok(pressure.y < 370, `${pressure.y} pixels above the first pressure`)
      const lines = page.getByRole('list', { name: 'Active alarms' }).getByRole('listitem')
      await becomes(() => lines.count(), 2)
      assert.match(await lines.last().innerText(), /^and [0-9]+ more$/)
      const control = page.locator('header').getByRole('button', { name: 'Request control' })
      const unit = page.getByLabel('Unit of pressure')
      assert.deepEqual([await control.isVisible(), await unit.isVisible()], [false, false])
      const menu = page.getByRole('button', { name: 'Control, unit, language and theme' })
      await becomes(() => menu.getAttribute('aria-expanded'), 'false')
      await menu.click()
      await becomes(() => menu.getAttribute('aria-expanded'), 'true')
      await unit.selectOption('hPa')
      await page.locator('.big', { hasText: 'hPa' }).first().waitFor()
      await control.click()
      await menu.click()
      await page.locator('header').getByText('You have control').waitFor()
      await page.locator('header').getByRole('button', { name: 'Release control' }).click()
      await control.waitFor({ state: 'hidden' })
    },
    PHONE,
  )
})

test('with a zoom of 200 % the header scrolls away with the page', async () => {
  await visit(
    plant.url,
    async (page) => {
      await page.locator('.card').first().waitFor()
      await page.evaluate(() => scrollTo(0, 400))
      assert.ok((await page.locator('header').evaluate((header) => header.getBoundingClientRect().bottom)) < 0)
    },
    { viewport: { width: 720, height: 450 } },
  )
})

test('the scale of a small line has its two decades with the unit between them, and its time below', async () => {
  await visit(plant.url, async (page) => {
    const card = page.locator('.card[data-gauge="chamber"]')
    await card.locator('.sparkline-scale span').first().waitFor()
    assert.match((await card.locator('.sparkline-scale').innerText()).replace(/\s+/g, ' '), /^10\S+ mbar 10\S+$/)
    const [time, line, whole] = await Promise.all(
      [card.locator('.sparkline-time'), card.locator('.sparkline svg'), card].map((one) => one.boundingBox()),
    )
    assert.ok(time.y >= line.y + line.height && time.y + time.height <= whole.y + whole.height)
  })
})

test('outside its range a gauge has a line with a band in its small picture, which is no gap', async () => {
  const own = await startPlant()
  try {
    await visit(own.url, async (page) => {
      const bands = (name) => page.locator(`.card[data-gauge="${name}"] .sparkline .outside`)
      await page.locator('.card[data-gauge="load lock"] .sparkline polyline').first().waitFor({ state: 'attached' })
      await becomes(() => bands('load lock').count(), 0)
      // Below the range of a PCG550.
      own.tell('load lock=1e-6')
      const [low, high] = ['load lock', 'gate 2'].map((name) => bands(name).last())
      await low.waitFor({ state: 'attached' })
      await high.waitFor({ state: 'attached' })
      assert.deepEqual(
        [await low.getAttribute('class'), await high.getAttribute('class')],
        ['outside under', 'outside over'],
      )
      const place = (one) =>
        one.evaluate((group) => {
          const [line, band] = ['line', 'rect'].map((name) => group.querySelector(name).getBBox())
          return { line: line.y, top: band.y, bottom: band.y + band.height }
        })
      const [under, over] = [await place(low), await place(high)]
      assert.ok(under.line === under.top && under.bottom > under.top + 5, JSON.stringify(under))
      assert.ok(over.line === over.bottom && over.bottom > over.top + 5, JSON.stringify(over))
      await page
        .locator('.card[data-gauge="load lock"] svg[aria-label$=", under range at times"]')
        .waitFor({ state: 'attached' })
      // The detector has a fault and no pressure: that stays a gap.
      await becomes(() => bands('cryostat').count(), 0)
    })
  } finally {
    await own.stop()
  }
})

test('on a phone the band of a gauge keeps its name beside the names of limits', async () => {
  const { page, complaints, close } = await openContext(browser, PHONE)
  try {
    // A canvas has no elements: its texts are those that the page has written.
    await page.addInitScript(() => {
      window.written = new Map()
      const { fillText } = CanvasRenderingContext2D.prototype
      CanvasRenderingContext2D.prototype.fillText = function (text, x, y, ...more) {
        if (this.textBaseline === 'top') window.written.set(text, { x, y, width: this.measureText(text).width })
        return fillText.call(this, text, x, y, ...more)
      }
    })
    const series = 's=chamber&s=load+lock&s=gate+1&s=gate+2&s=pump+stand.2'
    await page.goto(`${plant.url}/trends?range=1h&${series}`)
    await page.waitForFunction(() => window.written.has('gate 2 over range') && window.written.has('load lock: vented'))
    const [band, level, height] = await page.evaluate(() => [
      window.written.get('gate 2 over range'),
      window.written.get('load lock: vented'),
      12 * devicePixelRatio,
    ])
    const meet = band.x < level.x + level.width && level.x < band.x + band.width && Math.abs(band.y - level.y) < height
    assert.ok(!meet, JSON.stringify([band, level]))
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
})

test('no choice of the forms about rises is wider than its field, in both languages', async () => {
  for (const locale of ['en-GB', 'de-DE']) {
    for (const path of ['/rise?s=vessel', '/rise/identify?series=vessel']) {
      await visit(
        plant.url + path,
        async (page) => {
          await page.locator('main select').first().waitFor()
          for (const width of [1280, 900, 640, 360]) {
            await page.setViewportSize({ width, height: 800 })
            const cut = await page.locator('main select').evaluateAll((all) =>
              all.flatMap((one) => {
                const free = one.cloneNode(true)
                free.style.cssText = 'position: absolute; width: auto; max-width: none'
                one.after(free)
                const [needed, has] = [free.offsetWidth, one.offsetWidth]
                free.remove()
                return needed > has ? [`${one.ariaLabel}: ${needed} > ${has}`] : []
              }),
            )
            assert.deepEqual(cut, [], `${path} ${locale}, ${width} pixels`)
          }
        },
        { locale },
      )
    }
  }
})

test('in the chart of a rise no name meets another one, or the line of a mark', async () => {
  const { started_ms: end } = await plant.json('/api/station')
  // Beyond its range a gauge measures no pressure: the station refuses the fit.
  const refused = 'Failed to load resource: the server responded with a status of 400 (Bad Request)'
  for (const [series, begin, last, expected] of [
    ['vessel', end - 600_000, 'fit', []],
    ['gate+2', end - 60_000, 'gate 2 over range', [refused]],
  ]) {
    const { page, complaints, close } = await openContext(browser)
    try {
      await page.addInitScript(() => {
        window.written = new Map()
        window.verticals = new Set()
        const { clearRect, fillText, moveTo, lineTo } = CanvasRenderingContext2D.prototype
        let from = null
        Object.assign(CanvasRenderingContext2D.prototype, {
          clearRect(...rect) {
            window.written.clear()
            window.verticals.clear()
            return clearRect.apply(this, rect)
          },
          fillText(text, x, y, ...more) {
            if (this.textBaseline === 'top' && this.textAlign === 'left')
              window.written.set(text, { x, y, width: this.measureText(text).width })
            return fillText.call(this, text, x, y, ...more)
          },
          moveTo(x, y) {
            from = x
            return moveTo.call(this, x, y)
          },
          lineTo(x, y) {
            if (x === from && this.lineWidth === 2) window.verticals.add(x)
            return lineTo.call(this, x, y)
          },
        })
      })
      await page.goto(`${plant.url}/rise?s=${series}&begin=${begin}&end=${end}`)
      await page.waitForFunction((last) => window.written.has(last) && window.written.has('end'), last)
      const [written, verticals] = await page.evaluate(() => [[...window.written], [...window.verticals]])
      const names = written.filter(([text]) => ['valve closed', 'end', 'fit', 'vessel', last].includes(text))
      assert.ok(names.length >= 3 && verticals.length >= 2, JSON.stringify([names, verticals]))
      for (const [text, { x, y, width }] of names) {
        assert.ok(
          verticals.every((line) => line <= x || line >= x + width),
          `${text} at ${x}, ${width} wide, meets ${verticals}`,
        )
        for (const [other, place] of names.filter(([other]) => other !== text)) {
          const meet = x < place.x + place.width && place.x < x + width && Math.abs(y - place.y) < 12
          assert.ok(!meet, `${text} meets ${other}`)
        }
      }
      assert.deepEqual(complaints, expected)
    } finally {
      await close()
    }
  }
})

test('on a phone no page is wider than the screen, no word of a table or button is broken, no mark leaves its alarm', async () => {
  for (const locale of ['en-GB', 'de-DE']) {
    for (const url of ['/alarms', '/trends', '/events', '/audit', '/gauge/chamber', '/bus'].map(
      (path) => plant.url + path,
    )) {
      await visit(
        url,
        async (page) => {
          await page.locator('main .panel, main .log').first().waitFor()
          if (url.endsWith('/alarms')) {
            await page.locator('.alarm-item').first().waitFor()
            await page.locator('main summary h2').last().waitFor()
            await page.evaluate(() => {
              for (const one of document.querySelectorAll('main details')) one.open = true
              // The longest state.
              const state = document.querySelector('.alarm-item .alarm-state')
              state.textContent = 'gegangen, nicht quittiert'
            })
            await page.locator('.alarm-performance tbody tr').first().waitFor()
            // Lists that arrive later are opened too.
            await page.waitForFunction(() => {
              for (const one of document.querySelectorAll('main details')) one.open = true
              return document.querySelector('table.stacked button')?.checkVisibility()
            })
            assert.deepEqual(await tooWide(page, '.alarm-item .alarm-state'), [], locale)
          }
          const widest = await page.evaluate(() => document.documentElement.scrollWidth)
          assert.ok(widest <= 360, `${url} is ${widest} wide, ${locale}`)
          assert.deepEqual(await brokenWords(page, 'main :is(th, td, button)'), [], `${url} ${locale}`)
        },
        { ...PHONE, locale },
      )
    }
  }
})

test('on a phone no line of the alarms and events breaks between a number and its unit, or within a time', async () => {
  const quantities =
    /\d{4}-\d\d-\d\d \d\d:\d\d:\d\d|\d[\d.]*(e[+-]\d+|\s×\s10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?\s(mbar|decades\/min|Dekaden\/min|%|s|min|h)(?!\p{L})/gu
  for (const locale of ['en-GB', 'de-DE']) {
    for (const path of ['/alarms', '/events']) {
      await visit(
        plant.url + path,
        async (page) => {
          await page.locator('main .log tbody tr').first().waitFor()
          await page.waitForFunction(() => {
            for (const one of document.querySelectorAll('main details')) one.open = true
            return !location.pathname.includes('alarms') || document.querySelectorAll('main table').length >= 4
          })
          // At some width each quantity is at the end of a line.
          for (const width of [320, 336, 352, 360, 376, 392]) {
            await page.setViewportSize({ width, height: 740 })
            const broken = await brokenWords(page, 'main', quantities)
            assert.deepEqual(broken, [], `${path} ${locale}, ${width} pixels`)
          }
        },
        { ...PHONE, locale },
      )
    }
  }
})

/** The words of elements that begin in one line and end in another; a word with a hyphen may. */
const brokenWords = (page, selector, { source, flags } = /[\p{L}\p{N}]+/gu) =>
  page.locator(selector).evaluateAll(
    (all, [source, flags]) => {
      const pattern = new RegExp(source, flags)
      return all.flatMap((one) => {
        const words = []
        const walker = document.createTreeWalker(one, NodeFilter.SHOW_TEXT)
        const range = document.createRange()
        while (walker.nextNode()) {
          for (const word of walker.currentNode.data.matchAll(pattern)) {
            range.setStart(walker.currentNode, word.index)
            range.setEnd(walker.currentNode, word.index + word[0].length)
            const lines = new Set(
              [...range.getClientRects()].filter(({ width }) => width > 0).map(({ top }) => Math.round(top)),
            )
            if (lines.size > 1) words.push(word[0])
          }
        }
        return words
      })
    },
    [source, flags],
  )

test('a pressure is copied and read as one text, its power without a space', async () => {
  const whole = /^\d+\.?\d*( × 10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)? mbar$/
  for (const [path, selector] of [
    ['/trends', '.series-list'],
    ['/', '.several'],
  ]) {
    await visit(plant.url + path, async (page) => {
      await page.locator(`${selector} .power`).first().waitFor()
      const found = await page.locator(`${selector} .pressure`).evaluateAll((all) =>
        all.map((one) => {
          getSelection().selectAllChildren(one)
          return [one.innerText, getSelection().toString()]
        }),
      )
      assert.ok(found.length > 0)
      for (const text of found.flat()) assert.match(text, whole)
    })
  }
  // The name of an element is what a screen reader says.
  await visit(`${plant.url}/trends`, async (page) => {
    await page.getByRole('checkbox', { name: /^gate 1 \d\.\d\d × 10⁻[⁰¹²³⁴⁵⁶⁷⁸⁹] mbar$/ }).waitFor()
  })
})
