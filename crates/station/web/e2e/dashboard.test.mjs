// The dashboard as a person meets it: a real browser, a real server, scenery instead of a bus. Nothing waits for a time,
// everything for a condition.

import assert from 'node:assert/strict'
import { after, before, test } from 'node:test'
import { drawn, openPage, startBrowser, startPlant } from './desk.mjs'

let browser
let plant

before(async () => {
  ;[browser, plant] = await Promise.all([startBrowser(), startPlant('127.0.0.1:0', 'hostile')])
})

after(async () => {
  await browser?.close()
  await plant?.stop()
})

const PAGES = {
  '/': 'Overview',
  '/trends': 'Trends',
  '/bus': 'Bus map',
  '/gauge': 'Gauge',
  '/rise': 'Rate of rise',
  '/events': 'Events',
  '/alarms': 'Alarms',
  '/audit': 'Audit',
}

/** Opens a page of the plant, and afterwards holds it to have complained of nothing. */
async function visit(path, look, options = {}) {
  const { page, complaints, close } = await openPage(browser, plant.url + path, options)
  try {
    await look(page)
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
}

const text = (locator) => locator.innerText()
const big = (page, series) => page.locator(`.big[data-series="${series}"]`)
const windowOf = (page) => page.locator('.chart').evaluate(({ dataset }) => [Number(dataset.from), Number(dataset.to)])

test('every page loads and says which it is', async () => {
  for (const [path, name] of Object.entries(PAGES)) {
    await visit(path, async (page) => {
      assert.equal(await text(page.locator('nav [aria-current]')), name)
      assert.equal(await page.locator('h1').count(), 1)
      assert.equal(await page.title(), `${name} · Target hall`)
    })
  }
})

test('numbers are those of the API, in every unit', async () => {
  const { readings } = (await plant.json('/api/gauges')).find(({ name }) => name === 'turbo outlet')
  assert.deepEqual([readings[0].pa, readings[0].corrected_pa.toFixed(3)], [2.34, '3.978'])
  const shown = {
    mbar: '2.34 × 10⁻² mbar',
    hPa: '2.34 × 10⁻² hPa',
    Torr: '1.76 × 10⁻² Torr',
    micron: '17.6 micron',
    Pa: '2.34 Pa',
  }
  await visit('/', async (page) => {
    const card = page.locator('[data-gauge="turbo outlet"]')
    assert.match(await text(card), /Ar: 3\.98 × 10⁻² mbar/)
    for (const [unit, pressure] of Object.entries(shown)) {
      await page.getByLabel('Unit of pressure').selectOption(unit)
      assert.equal(await text(big(page, 'turbo outlet')), pressure)
    }
    await page.reload()
    assert.equal(await text(big(page, 'turbo outlet')), '2.34 Pa')
  })
})

test('what is no pressure is a word and never a number', async () => {
  await visit('/', async (page) => {
    assert.equal(await text(big(page, 'gate 2')), 'over range')
    assert.match(await text(page.locator('[data-gauge="gate 2"]')), /above 1\.00 × 10⁻² mbar/)
    assert.equal(await text(big(page, 'cryostat')), 'not valid')
    assert.match(await text(page.locator('[data-gauge="cryostat"]')), /filament broken/)
    assert.equal(await text(big(page, 'oven')), 'no data')
    assert.match(await text(page.locator('[data-gauge="oven"]')), /no data since \d\d:\d\d:\d\d \(5 min/)
    assert.match(await text(page.locator('[data-gauge="spare"]')), /never heard/)
  })
})

test('what changes is shown as it changes', async () => {
  await visit('/', async (page) => {
    const cards = ['gate 1', 'transfer'].map((name) => big(page, name))
    for (const card of cards) {
      const first = await text(card)
      await page.waitForFunction(([element, first]) => element.innerText !== first, [await card.elementHandle(), first])
    }
  })
})

test('a zoom is fetched again for the pixels there are', async () => {
  await visit('/trends?s=chamber&range=1d', async (page) => {
    await drawn(page)
    const box = await page.locator('.chart .u-over').boundingBox()
    const before = await windowOf(page)
    const [request] = await Promise.all([
      page.waitForRequest((request) => request.url().includes('/api/trend') && span(request) < 20 * 3_600_000),
      drag(page, box, 0.25, 0.75),
    ])
    const after = await windowOf(page)
    assert.ok(Math.abs((after[1] - after[0]) / (before[1] - before[0]) - 0.5) < 0.01, `${before} ${after}`)
    const bins = Number(new URL(request.url()).searchParams.get('pixels'))
    assert.ok(
      Math.abs((bins * (after[1] - after[0])) / span(request) - box.width) < 3,
      `${bins} pixels for ${box.width}`,
    )
    await Promise.all([
      page.waitForRequest((request) => request.url().includes('/api/trend') && span(request) < 8 * 3_600_000),
      wheel(page, box, -150),
    ])
    assert.match(page.url(), /from=\d+&to=\d+/)
    await page.getByRole('button', { name: '10 min' }).click()
    await page.waitForFunction(
      () =>
        Math.round(
          (document.querySelector('.chart').dataset.to - document.querySelector('.chart').dataset.from) / 1000,
        ) === 600,
    )
  })
})

function span(request) {
  const { searchParams } = new URL(request.url())
  return searchParams.get('to') - searchParams.get('from')
}

async function drag(page, box, from, to) {
  await page.mouse.move(box.x + box.width * from, box.y + 100)
  await page.mouse.down()
  await page.mouse.move(box.x + box.width * to, box.y + 120, { steps: 4 })
  await page.mouse.up()
}

async function wheel(page, box, by) {
  await page.mouse.move(box.x + box.width / 2, box.y + 100)
  await page.mouse.wheel(0, by)
}

/** Which columns of a chart have the colour of its first curve: [time, whether] for each pixel. */
const COLUMNS = () => {
  const canvas = document.querySelector('.chart canvas')
  const box = canvas.getBoundingClientRect()
  const over = document.querySelector('.chart .u-over').getBoundingClientRect()
  const scale = canvas.width / box.width
  const { from, to } = document.querySelector('.chart').dataset
  const [left, top] = [Math.round((over.left - box.left) * scale), Math.round((over.top - box.top) * scale)]
  const [width, height] = [Math.round(over.width * scale), Math.round(over.height * scale)]
  const { data } = canvas.getContext('2d').getImageData(left, top, width, height)
  const swatch = document.querySelector('.readout li:not(.off) .swatch')
  const [r, g, b] = getComputedStyle(swatch).backgroundColor.match(/\d+/g).map(Number)
  const isColour = (at) => Math.abs(data[at] - r) + Math.abs(data[at + 1] - g) + Math.abs(data[at + 2] - b) < 40
  return Array.from({ length: width }, (_, x) => {
    const column = Array.from({ length: height }, (_, y) => isColour(4 * (y * width + x)))
    return [Number(from) + ((Number(to) - Number(from)) * (x + 0.5)) / width, column.some(Boolean)]
  })
}

test('a gap is drawn as a gap', async () => {
  const { started_ms } = await plant.json('/api/station')
  await visit(`/trends?s=gate+1&s=detector&from=${started_ms - 900_000}&to=${started_ms}`, async (page) => {
    await drawn(page)
    const columns = (await page.evaluate(COLUMNS)).map(([time, has]) => [(time - started_ms) / 1000, has])
    const part = (from, to) => {
      const inside = columns.filter(([second]) => second > from && second < to)
      return inside.filter(([, has]) => has).length / inside.length
    }
    assert.ok(part(-890, -545) > 0.95, `before: ${part(-890, -545)}`)
    assert.ok(part(-320, -10) > 0.95, `after: ${part(-320, -10)}`)
    assert.equal(part(-535, -335), 0)
  })
})

test('the cursor reads all curves at once, and says when there is nothing', async () => {
  const { started_ms } = await plant.json('/api/station')
  await visit(`/trends?s=gate+1&s=turbo+outlet&from=${started_ms - 900_000}&to=${started_ms}`, async (page) => {
    await drawn(page)
    const box = await page.locator('.chart .u-over').boundingBox()
    const value = (name) => text(page.locator('.readout li', { hasText: name }).locator('.value'))
    await page.mouse.move(box.x + box.width * (450 / 900), box.y + 50)
    await page.locator('.readout-time strong', { hasText: ':' }).waitFor()
    assert.deepEqual([await value('gate 1'), await value('turbo outlet')], ['no data', '2.34 × 10⁻² mbar'])
    await page.mouse.move(box.x + box.width * (800 / 900), box.y + 50)
    await page.locator('.readout li', { hasText: 'gate 1' }).locator('.value', { hasText: 'mbar' }).waitFor()
  })
})

test('nothing of the header is cut off, whatever the window', async () => {
  for (const [width, height] of [
    [1280, 800],
    [768, 1024],
    [360, 740],
  ]) {
    const look = async (page) => {
      const boxes = await page
        .locator('header :is(a, button, select)')
        .evaluateAll((all) => all.map((one) => one.getBoundingClientRect().toJSON()))
      assert.ok(boxes.length >= 12)
      for (const { left, right, top, bottom } of boxes)
        assert.ok(left >= 0 && right <= width && top >= 0 && bottom <= 260, `${width}: ${left} to ${right}`)
      const hides = await page.locator('nav').evaluate((nav) => nav.scrollWidth - nav.clientWidth)
      assert.equal(hides, 0, `${width}: pages are hidden`)
    }
    await visit('/alarms', look, { viewport: { width, height } })
  }
})

test('what an alarm says has a line of its own, and no page is wider than its window', async () => {
  const look = async (page) => {
    const item = page.locator('.alarm-item').first()
    await item.waitFor()
    const [name, words] = await item
      .locator('.what > *')
      .evaluateAll((all) => all.map((one) => one.getBoundingClientRect().toJSON()))
    assert.equal(words.left, name.left)
    assert.ok(words.top >= name.bottom)
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)) <= 0)
  }
  await visit('/alarms', look)
  await visit('/alarms', look, { viewport: { width: 390, height: 844 } })
})

test('every page is reached by keys', async () => {
  await visit('/', async (page) => {
    for (const [path, name] of Object.entries(PAGES)) {
      await page.keyboard.press(await page.locator(`nav a[href="${path}"]`).getAttribute('aria-keyshortcuts'))
      await page.locator('nav [aria-current]', { hasText: name }).waitFor()
      assert.equal(new URL(page.url()).pathname, path)
    }
    await page.keyboard.press('?')
    await page.getByRole('dialog').waitFor()
    for (const words of ['Alarms', 'Audit', 'over, new', 'kept on request'])
      await page.getByRole('dialog').getByText(words, { exact: true }).waitFor()
    await page.keyboard.press('Escape')
    await page.getByRole('dialog').waitFor({ state: 'hidden' })
    await page.keyboard.press('1')
    await page.keyboard.press('u')
    await page.locator('.big', { hasText: 'hPa' }).first().waitFor()
    // Whoever writes means letters.
    await page.keyboard.press('6')
    await page.getByLabel('Search events').fill('1')
    assert.equal(new URL(page.url()).pathname, '/events')
  })
})

test('a key that is pressed while a page is being drawn counts', async () => {
  await visit('/events', async (page) => {
    await page.evaluate(async () => {
      const press = (key) => document.body.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }))
      press('1')
      while (!document.querySelector('.big')) await Promise.resolve()
      press('u')
    })
    await page.locator('.big', { hasText: 'hPa' }).first().waitFor()
  })
})

test('everything that can be pressed is reached by Tab, and shows it', async () => {
  await visit('/bus', async (page) => {
    const wanted = await page.evaluate(
      () => document.querySelectorAll('a, button, select, input, [tabindex="0"]').length,
    )
    const seen = new Set()
    for (let step = 0; step < wanted; step += 1) {
      await page.keyboard.press('Tab')
      const [name, outline] = await page.evaluate(() => {
        const focused = document.activeElement
        const all = [...document.querySelectorAll('a, button, select, input, [tabindex="0"]')]
        return [all.indexOf(focused), getComputedStyle(focused).outlineStyle]
      })
      assert.equal(outline, 'solid', `element ${name}`)
      seen.add(name)
    }
    assert.equal(seen.size, wanted)
  })
})

test('a chart is moved by keys', async () => {
  await visit('/trends?s=chamber', async (page) => {
    await drawn(page)
    await page.locator('.chart').focus()
    const [from, to] = await windowOf(page)
    await page.keyboard.press('+')
    await page.waitForFunction((before) => document.querySelector('.chart').dataset.from > before, from + 60_000)
    const [closer, end] = await windowOf(page)
    assert.equal(Math.round((end - closer) / 1000), Math.round((to - from) / 2000))
    await page.keyboard.press('ArrowLeft')
    await page.waitForFunction((before) => document.querySelector('.chart').dataset.from < before, closer)
    await page.keyboard.press('Home')
    await page.getByRole('button', { name: '1 hour', pressed: true }).waitFor()
  })
})

test('a phone shows every page without scrolling sideways', async () => {
  for (const path of ['/', '/trends', '/bus', '/gauge/chamber', '/rise?s=vessel', '/events']) {
    await visit(
      path,
      async (page) => {
        await page.locator('main :is(.card, .panel)').first().waitFor()
        if (path === '/gauge/chamber') await page.locator('.parameters').first().waitFor()
        const [needed, width] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth])
        assert.ok(needed <= 320 && width === 320, `${path} needs ${needed} of ${width} pixels`)
      },
      { viewport: { width: 320, height: 640 }, isMobile: true, hasTouch: true },
    )
  }
})

test('colours follow the system until somebody chooses', async () => {
  const ground = (page) => page.evaluate(() => getComputedStyle(document.body).backgroundColor)
  await visit(
    '/',
    async (page) => {
      const dark = await ground(page)
      await page.emulateMedia({ colorScheme: 'light' })
      const light = await ground(page)
      assert.notEqual(dark, light)
      await page.getByRole('button', { name: 'Colours: auto' }).click()
      await page.getByRole('button', { name: 'Colours: light' }).click()
      assert.equal(await ground(page), dark)
      await page.reload()
      assert.equal(await ground(page), dark)
    },
    { colorScheme: 'dark' },
  )
})

test('the bus map tells who is where', async () => {
  await visit('/bus', async (page) => {
    const hall = page.locator('[data-segment="hall"]')
    assert.equal(await hall.locator('.cell').count(), 127)
    assert.equal(await hall.locator('button.cell').count(), 9)
    await hall.getByRole('button', { name: /^2: / }).click()
    assert.match(await text(hall.locator('.detail')), /another master in the ring/)
    await hall.getByRole('button', { name: /^9: cryostat/ }).click()
    assert.match(await text(hall.locator('.detail')), /filament broken/)
    assert.match(await text(hall.locator('.facts')), /93\.75 kbit\/s[^]*ms/)
    assert.match(await text(page.locator('[data-segment="bench"] .sentence')), /the port is lost/)
    await hall.locator('.detail a').click()
    assert.equal(new URL(page.url()).pathname, '/gauge/cryostat')
  })
})

test('parameters are read, searched, and read again', async () => {
  await visit('/gauge/chamber', async (page) => {
    await page.locator('.progress', { hasText: 'read at' }).waitFor()
    const blocks = await plant.json('/api/gauges/chamber/blocks')
    assert.equal(
      await page.locator('.parameters tbody tr').count(),
      blocks.flatMap(({ parameters }) => parameters).length,
    )
    await page.getByLabel('Search parameters').fill('trip status')
    assert.deepEqual(await page.locator('.parameters tbody th code').allInnerTexts(), ['trip-point.1/status'])
    await Promise.all([
      page.waitForRequest((request) => request.url().endsWith('/blocks')),
      page.getByRole('button', { name: 'Read again' }).click(),
      page.locator('.progress.busy').waitFor(),
    ])
    await page.locator('.progress', { hasText: 'read at' }).waitFor()
  })
})

test('a rise is marked by dragging, and told apart', async () => {
  const { started_ms } = await plant.json('/api/station')
  await visit(`/rise?s=vessel&litres=12&begin=${started_ms - 600_000}&end=${started_ms}`, async (page) => {
    await page.locator('.result h2', { hasText: 'Mostly outgassing, and a leak' }).waitFor()
    const flows = await page.locator('.flows tbody tr').first().locator('td').allInnerTexts()
    // 2.4e-3 Pa/s in 12 L are 2.88e-5 Pa m³/s; the fit finds it within some percent.
    const [mbarLitres, pascalCubic, sccm] = flows.map((cell) =>
      Number(cell.replace(/ × 10⁻(.)/, (_, power) => `e-${'⁰¹²³⁴⁵⁶⁷⁸⁹'.indexOf(power)}`)),
    )
    assert.ok(Math.abs(pascalCubic / 2.88e-5 - 1) < 0.05, flows.join())
    assert.ok(
      Math.abs(mbarLitres / pascalCubic - 10) < 0.05 && Math.abs(mbarLitres / sccm / 0.01689 - 1) < 0.01,
      flows.join(),
    )
  })
  await visit('/rise?s=vessel', async (page) => {
    await drawn(page)
    await drag(page, await page.locator('.chart .u-over').boundingBox(), 0.7, 0.95)
    await page.locator('.result h2').waitFor()
    assert.match(page.url(), /begin=\d+&end=\d+/)
  })
})

test('events are found by kind and by word', async () => {
  await visit('/events', async (page) => {
    const rows = page.locator('.events tbody tr')
    await rows.first().waitFor()
    assert.match(await text(rows.first()), /the station begins/)
    await page.getByLabel('Kind').selectOption('note')
    assert.equal(await rows.count(), 1)
    await page.getByLabel('Kind').selectOption('')
    await page.getByLabel('Search events').fill('degas')
    assert.equal(await rows.count(), 2)
  })
})

test('a name that is a script is a name', async () => {
  const name = '<img src=x onerror=alert(1)>'
  for (const [path, place] of [
    ['/', '.card h3'],
    [`/trends?${new URLSearchParams({ s: name })}`, '.readout .name'],
    [`/gauge/${encodeURIComponent(name)}`, '.now h2'],
  ]) {
    await visit(path, async (page) => {
      await page.locator(place).getByText(name, { exact: true }).waitFor()
      assert.equal(await page.locator('img').count(), 0)
    })
  }
})

test('a station that stops is shown as lost, and found again', async () => {
  let mortal = await startPlant()
  const { address } = mortal
  const { page, close } = await openPage(browser, mortal.url)
  try {
    const card = page.locator('[data-gauge="turbo outlet"]')
    assert.ok(!(await card.getAttribute('class')).includes('stale'))
    await mortal.stop()
    await page.locator('.link.lost').waitFor()
    await page.getByRole('alert').getByText('The connection to the station is lost').waitFor()
    await page.locator('[data-gauge="turbo outlet"].stale', { hasText: 'no data since' }).waitFor()
    mortal = await startPlant(address)
    await page.locator('.link.good').waitFor()
    await page.locator('[data-gauge="turbo outlet"]:not(.stale)').waitFor()
    assert.equal(await page.getByRole('alert').count(), 0)
  } finally {
    await close()
    await mortal.stop()
  }
})
