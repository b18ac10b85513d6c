// Alarms in a browser: raised, acknowledged, cleared; and what each role may do.

import assert from 'node:assert/strict'
import { mkdtemp, readFile, rm, writeFile } from 'node:fs/promises'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after, before, test } from 'node:test'
import { violations } from './axe.mjs'
import { addUser, becomes, openContext, startBrowser, startGauges, startPlant, startStation } from './setup.mjs'

const PASSWORD = 'tin whisker plateau'

let browser
let plant

before(async () => {
  ;[browser, plant] = await Promise.all([startBrowser(), startPlant('127.0.0.1:0', 'users')])
})

after(async () => {
  await browser?.close()
  await plant?.stop()
})

/** Shows a user the alarms page after the login. */
async function as(name, look, options = {}, { url } = plant) {
  const { page, complaints, close } = await openContext(browser, options)
  try {
    await page.goto(`${url}/alarms`)
    await page.getByLabel('Name').fill(name)
    await page.getByLabel('Password', { exact: true }).fill(PASSWORD)
    await page.getByLabel('Password', { exact: true }).press('Enter')
    await page.locator('.alarm-item, .alarm-group').first().waitFor()
    await look(page)
    // Chromium reports a refused request as an error on the console.
    assert.deepEqual(
      complaints.filter((complaint) => !/status of (400|401|403)/.test(complaint)),
      [],
    )
  } finally {
    await close()
  }
}

const item = (page, name) => page.locator(`[data-alarm="${name}"]:not(.out-of-service):not(.shelved)`)
const text = (locator) => locator.innerText()

/** Shows the details of an alarm. */
const open = (page, name) => item(page, name).locator('button.name').click()

test('an alarm is raised, acknowledged and cleared', async () => {
  await as('olga', async (page) => {
    const vented = item(page, 'vessel vented')
    await becomes(() => vented.count(), 0)
    plant.tell('vessel=5e4')
    await vented.waitFor()
    assert.match(await text(vented), /1 high\s+not acknowledged/)
    assert.match(await text(vented), /vessel vented\s+Limit\s+> 10\.0\smbar\s+Now\s+500\smbar/)
    await vented.getByRole('button', { name: 'Acknowledge' }).click()
    await page.waitForFunction(
      () => document.querySelector('[data-alarm="vessel vented"] .alarm-state').innerText === 'acknowledged',
    )
    await open(page, 'vessel vented')
    assert.match(await text(vented), /vessel above 10\.0\smbar, until below .*acknowledged by olga/s)
    plant.tell('vessel=1')
    await vented.waitFor({ state: 'detached' })
    const history = page.getByRole('region', { name: 'History' })
    await history.getByRole('searchbox').fill('vessel vented')
    const rows = history.locator('tbody tr')
    await page.waitForFunction(() => document.querySelectorAll('.alarm-history tbody tr').length === 3)
    const told = await rows.evaluateAll((rows) => rows.map((row) => [row.cells[2].innerText, row.cells[4].innerText]))
    assert.deepEqual(told, [
      ['cleared', ''],
      ['acknowledged', 'olga'],
      ['raised', ''],
    ])
    await history.getByLabel('Change').selectOption('raised')
    await becomes(() => rows.count(), 1)
  })
})

test('the history is of the chosen time, sorted by a press on the head of a column, and saved as CSV', async () => {
  await as('vera', async (page) => {
    const history = page.getByRole('region', { name: 'History' })
    const rows = history.locator('tbody tr')
    const priorities = () => rows.evaluateAll((rows) => rows.map(({ cells }) => cells[1].innerText.slice(0, 1)))
    await rows.nth(1).waitFor()
    await history.getByRole('button', { name: 'Priority', exact: true }).click()
    await history.locator('th[aria-sort="ascending"]', { hasText: 'Priority' }).waitFor()
    await history.getByRole('button', { name: 'Priority', exact: true }).click()
    await history.locator('th[aria-sort="descending"]', { hasText: 'Priority' }).waitFor()
    const shown = await priorities()
    assert.deepEqual(shown, [...shown].sort().reverse())
    const saved = page.waitForEvent('download')
    await history.getByRole('button', { name: 'Save as CSV' }).click()
    const file = await saved
    assert.match(file.suggestedFilename(), /^alarms \d{4}-\d\d-\d\d\.csv$/)
    const [head, ...lines] = (await readFile(await file.path(), 'utf8')).trimEnd().split('\n')
    assert.match(head, /^time,alarm,subject,priority,change/)
    assert.ok(lines.length >= shown.length, `${lines.length} of ${shown.length}`)
    await history.getByLabel('Time').selectOption('between two times')
    await history.getByLabel('To', { exact: true }).fill('2020-01-31 14:00')
    await history.getByLabel('To', { exact: true }).press('Enter')
    await history.getByText('No entry matches.').waitFor()
    await history.getByLabel('Time').selectOption('last day')
    await rows.nth(1).waitFor()
  })
})

test('a press on the head of a column sorts the active alarms, and the choice of the order follows', async () => {
  await as('vera', async (page) => {
    const list = page.getByRole('region', { name: 'Active alarms' })
    const order = list.getByLabel('Order')
    const head = (name) => list.locator('.alarm-head button', { hasText: name })
    await head('Alarm').click()
    await becomes(() => order.inputValue(), 'alarm')
    const names = await list.locator('.alarm-item').evaluateAll((items) => items.map(({ dataset }) => dataset.alarm))
    assert.deepEqual(
      names,
      [...names].sort((one, other) => one.localeCompare(other)),
    )
    await head('Raised').click()
    await becomes(() => order.inputValue(), 'newest')
    await head('Raised').click()
    await becomes(() => order.inputValue(), 'oldest')
    await head('Raised').click()
    await becomes(() => order.inputValue(), 'urgency')
  })
})

/** A browser that plays into `tones`. */
const withTones = () => {
  window.tones = []
  window.AudioContext = class extends EventTarget {
    state = 'running'
    currentTime = 0
    destination = {}
    resume = () => Promise.resolve()
    createGain = () => {
      const gain = { value: 0, setValueAtTime: () => {}, linearRampToValueAtTime: () => {} }
      return { gain, connect: (to) => to }
    }
    createOscillator = () => {
      const frequency = { value: 0 }
      return { frequency, connect: (to) => to, start: () => window.tones.push(frequency.value), stop: () => {} }
    }
  }
}

test('alarms sound where the user wants it, until he silences them, and the next alarm sounds again, on the wall too', async () => {
  await as('olga', async (page) => {
    await page.addInitScript(withTones)
    await page.reload()
    const sound = page.getByRole('region', { name: 'Active alarms' }).getByLabel('Sound')
    const sounds = page.locator('.alarm-sound[data-sounds="high"]')
    assert.equal(await sound.isChecked(), false)
    await sound.check()
    await sounds.waitFor()
    await becomes(() => page.evaluate(() => window.tones[0]), 880)
    await sounds.getByRole('button', { name: 'Silence' }).click()
    await page.locator('.alarm-sound').waitFor({ state: 'detached' })
    plant.tell('vessel=5e4')
    await sounds.waitFor()
    await page.goto(`${plant.url}/wall`)
    await page.locator('.wall-head').locator(sounds).getByRole('button', { name: 'Silence' }).click()
    await page.locator('.alarm-sound').waitFor({ state: 'detached' })
    await page.goto(`${plant.url}/alarms`)
    await item(page, 'vessel vented').waitFor()
    assert.equal(await sound.isChecked(), true)
    await becomes(() => page.locator('.alarm-sound').count(), 0)
    plant.tell('vessel=1')
    await item(page, 'vessel vented').getByRole('button', { name: 'Acknowledge' }).click()
    await item(page, 'vessel vented').waitFor({ state: 'detached' })
  })
})

test('an alarm that clears before it is acknowledged stays in the list until then', async () => {
  await as('olga', async (page) => {
    plant.tell('vessel=5e4')
    const vented = item(page, 'vessel vented')
    await vented.waitFor()
    plant.tell('vessel=1')
    await page.waitForFunction(
      () =>
        document.querySelector('[data-alarm="vessel vented"] .alarm-state').innerText === 'cleared, not acknowledged',
    )
    await vented.getByRole('button', { name: 'Acknowledge' }).click()
    await vented.waitFor({ state: 'detached' })
  })
})

test('the instruction of a cleared alarm is no longer bold', async () => {
  await as('vera', async (page) => {
    const gate = item(page, 'gate 2 not evacuated')
    const weight = () => gate.locator('.message').evaluate((one) => getComputedStyle(one).fontWeight)
    assert.equal(await weight(), '600')
    plant.tell('gate 2=1e-3')
    await gate.locator('.alarm-state.returned').waitFor()
    assert.equal(await weight(), '400')
    plant.tell('gate 2=1.05e5')
    await gate.locator('.alarm-state.unacknowledged').waitFor()
  })
})

test('each action of an alarm has a place of its own', async () => {
  await as('ada', async (page) => {
    for (const width of [1920, 1280, 900, 360]) {
      await page.setViewportSize({ width, height: 800 })
      for (const place of ['button.acknowledge', '.tick input']) {
        const places = page.getByRole('region', { name: 'Active alarms' }).locator(place)
        const lefts = await places.evaluateAll((all) => all.map((one) => one.getBoundingClientRect().left))
        assert.ok(lefts.length > 1, place)
        assert.equal(new Set(lefts).size, 1, `${place} at ${lefts}, ${width} pixels`)
      }
    }
  })
})

test('the most urgent alarm comes first', async () => {
  await as('vera', async (page) => {
    const marks = await page
      .locator('.alarm-list')
      .first()
      .locator('.alarm-item')
      .evaluateAll((items) => items.map((item) => item.dataset.priority))
    const rank = ['high', 'medium', 'low']
    assert.deepEqual(
      marks,
      [...marks].sort((one, other) => rank.indexOf(one) - rank.indexOf(other)),
    )
    assert.ok(marks.includes('high') && marks.includes('low'), marks.join())
  })
})

test('a viewer sees all alarms and has no buttons', async () => {
  await as('vera', async (page) => {
    assert.match(await text(item(page, 'gate 2 not evacuated')), /Keep the gate valve closed/)
    await becomes(() => page.getByRole('button', { name: /Acknowledge|Out of service|Return to service/ }).count(), 0)
    const status = await page.evaluate(async () => {
      const { token } = await (await fetch('/api/session')).json()
      const headers = { 'content-type': 'application/json', 'x-csrf-token': token }
      const answer = await fetch('/api/alarms/gate%202%20not%20evacuated/acknowledge', {
        method: 'POST',
        headers,
        body: '{"occurrence":1}',
      })
      return [answer.status, (await answer.json()).detail]
    })
    assert.deepEqual(status, [403, 'acknowledging an alarm needs the role operator, vera has viewer'])
  })
})

test('an engineer takes an alarm out of service with a reason, an operator cannot', async () => {
  await as('olga', async (page) => {
    await open(page, 'gate 2 not evacuated')
    assert.equal(
      await item(page, 'gate 2 not evacuated')
        .getByRole('button', { name: /Out of service/ })
        .count(),
      0,
    )
  })
  await as('ada', async (page) => {
    const gate = item(page, 'gate 2 not evacuated')
    await open(page, 'gate 2 not evacuated')
    await gate.getByRole('button', { name: 'Out of service: gate 2 not evacuated' }).click()
    const dialog = page.getByRole('dialog')
    await dialog.getByRole('button', { name: 'Take out of service' }).click()
    assert.ok(await dialog.isVisible(), 'the form is sent without a reason')
    await dialog.getByLabel('Reason').fill('The gauge is being calibrated.')
    await dialog.getByLabel('Duration').selectOption({ label: '8 hours' })
    await dialog.getByRole('button', { name: 'Take out of service' }).click()
    await gate.waitFor({ state: 'detached' })
    const out = page.locator('.alarm-item.out-of-service[data-alarm="gate 2 not evacuated"]')
    assert.match(await text(out), /The gauge is being calibrated\.\s+ada, .*, until /)
    await out.getByRole('button', { name: 'Return to service' }).click()
    await gate.waitFor()
    assert.match(await text(gate), /not acknowledged/)
  })
})

test('an operator shelves all active alarms together, with a reason and an end', async () => {
  await as('vera', async (page) => {
    await open(page, 'gate 2 not evacuated')
    assert.equal(await page.getByRole('button', { name: /^Shelve/ }).count(), 0, 'a viewer cannot')
  })
  await as('olga', async (page) => {
    const gate = item(page, 'gate 2 not evacuated')
    const active = page.getByRole('region', { name: 'Active alarms' })
    const names = await active.locator('[data-alarm]').evaluateAll((items) => items.map((it) => it.dataset.alarm))
    assert.ok(names.length > 1, `${names}`)
    await active.getByRole('button', { name: `Shelve all ${names.length} …` }).click()
    const dialog = page.getByRole('dialog')
    for (const name of names) assert.ok((await text(dialog)).includes(name), name)
    await becomes(() => dialog.getByLabel('Duration').locator('option').last().innerText(), '12 hours')
    await dialog.getByLabel('Reason').fill('The plant is vented.')
    await dialog.getByRole('button', { name: 'Shelve' }).click()
    await gate.waitFor({ state: 'detached' })
    const shelved = page.getByRole('region', { name: 'Shelved' })
    await page.waitForFunction(
      (count) => document.querySelectorAll('.alarm-item.shelved').length === count,
      names.length,
    )
    assert.match(await text(shelved), /The plant is vented\.\s+olga, .*, until /)
    await shelved.getByRole('button', { name: `Unshelve all ${names.length}` }).click()
    await shelved.waitFor({ state: 'detached' })
    await gate.waitFor()
  })
})

test('an engineer changes the limit of an alarm', async () => {
  plant.tell('vessel=500')
  await as('ada', async (page) => {
    const all = page.getByRole('region', { name: 'All alarms' })
    await all.locator('summary').click()
    await all.getByRole('searchbox').fill('vessel vented')
    const row = all.locator('tbody tr')
    await row.getByRole('button', { name: 'Settings: vessel vented' }).click()
    const dialog = page.getByRole('dialog', { name: 'Alarm settings' })
    await becomes(() => dialog.getByLabel('Above').inputValue(), '10 mbar')
    await becomes(() => dialog.getByLabel('Off-delay').inputValue(), '0 s')
    await becomes(() => dialog.getByLabel('Hysteresis in decades').getAttribute('placeholder'), '0.1')
    await dialog.getByLabel('Reason').fill('The process needs it.')
    // A refused value stays in the dialog, with the sentence of the station.
    await dialog.getByLabel('Above').fill('4 bananas')
    await dialog.getByRole('button', { name: 'Change' }).click()
    assert.match(await text(dialog.getByRole('alert')), /bananas/)
    await dialog.getByLabel('Above').fill('4 mbar')
    await dialog.getByRole('button', { name: 'Change' }).click()
    await dialog.waitFor({ state: 'detached' })
    // 500 Pa are above the new limit and below the former one.
    await item(page, 'vessel vented').waitFor()
    assert.match(await text(row), /vessel above 4\.00\smbar/)
    await page.goto(`${plant.url}/audit`)
    const entry = page.locator('tbody tr').filter({ hasText: 'vessel vented' }).first()
    await entry.waitFor()
    assert.match(await text(entry), /settings.*above = "10 mbar".*above = "4 mbar".*The process needs it\./s)
  })
  plant.tell('vessel=1')
  await as('olga', async (page) => {
    await becomes(() => page.getByRole('button', { name: /^Settings/ }).count(), 0)
    const all = page.getByRole('region', { name: 'All alarms' })
    await all.locator('summary').click()
    await becomes(() => all.getByRole('button', { name: /^Settings/ }).count(), 0)
  })
})

test('the settings of an alarm show the pressure at their opening, and the reset value of what is typed', async () => {
  await as('ada', async (page) => {
    plant.tell('vessel=5e4')
    const vented = item(page, 'vessel vented')
    await vented.filter({ hasText: /Now 500\smbar/ }).waitFor()
    await open(page, 'vessel vented')
    await vented.getByRole('button', { name: 'Settings: vessel vented' }).click()
    const dialog = page.getByRole('dialog', { name: 'Alarm settings' })
    const reset = dialog.locator('.reset-value')
    const resetIs = (value) => reset.filter({ hasText: value }).waitFor()
    await dialog.getByLabel('Above').fill('10 mbar')
    await resetIs(/Reset value\s*7\.94\smbar/)
    await dialog.getByLabel('Hysteresis in decades').fill('1')
    await resetIs(/1\.00\smbar/)
    assert.deepEqual(await violations(page), [])
    // The station refuses a reset value together with a hysteresis, and a pressure without a unit.
    await dialog.getByLabel('or reset at').fill('2 mbar')
    await reset.waitFor({ state: 'hidden' })
    await dialog.getByLabel('Hysteresis in decades').fill('')
    await resetIs(/2\.00\smbar/)
    const top = () => dialog.getByLabel('Above').evaluate((field) => field.getBoundingClientRect().top)
    const before = await top()
    await dialog.getByLabel('Above').fill('10')
    await reset.waitFor({ state: 'hidden' })
    assert.equal(await top(), before, 'the field moves while the engineer types')
    plant.tell('vessel=1')
    await vented.locator('.alarm-state.returned').waitFor()
    assert.match(await text(dialog), /vessel at \d\d:\d\d:\d\d\s+500\smbar/)
    await dialog.getByRole('button', { name: 'Cancel' }).click()
    await dialog.waitFor({ state: 'detached' })
  })
})

test('an e-mail that is not delivered is told with its reason', async () => {
  await as('vera', async (page) => {
    const panel = page.getByRole('region', { name: 'Notifications' })
    await panel.getByText('failing since').waitFor()
    assert.match(await text(panel), /shift e-mail smtp:\/\/127\.0\.0\.1:9 failing since .*: .*refused.*, \d+ queued/i)
  })
})

test('the figures name the most frequent alarms beside the targets', async () => {
  await as('vera', async (page) => {
    const figures = page.getByRole('region', { name: 'Alarm performance' })
    await figures.locator('summary').click()
    await figures.getByRole('table', { name: 'Alarm performance' }).waitFor()
    const table = await text(figures.getByRole('table', { name: 'Alarm performance' }))
    assert.match(table, /per hour\s+–\s+about 6, at most 12/)
    assert.match(table, /most in ten minutes\s+(▲ )?\d+, from \d{4}-/)
    const frequent = await text(figures.getByRole('table', { name: 'Most frequent alarms' }))
    assert.match(frequent, /gate 2 not evacuated\s+\d+\s+\d+ %/)
    await figures.getByLabel('Period').selectOption('7')
    await figures.getByRole('table', { name: 'Alarm performance' }).waitFor()
  })
})

/** The open panel of the alarm performance with these figures in place of those of the station. */
async function performancePanel(page, figures) {
  await page.route('**/api/alarms/performance?*', async (route) => {
    const answer = await route.fetch()
    await route.fulfill({ response: answer, json: { ...(await answer.json()), ...figures } })
  })
  const panel = page.getByRole('region', { name: 'Alarm performance' })
  await panel.locator('summary').click()
  // The figures that were fetched before are those of the station.
  await panel.getByLabel('Period').selectOption('7')
  return panel
}

test('a figure beyond its target has a shape and words, and no colour', async () => {
  const within = {
    recorded_hours: 24,
    per_hour: 12,
    worst_ten_minutes: { raised: 10, from_ms: 1e12 },
    flood_percent: 0.9,
    raised: 100,
    by_priority: { high: 5, medium: 15, low: 80 },
    chattering: [],
  }
  const beyond = {
    recorded_hours: 24,
    per_hour: 12.1,
    worst_ten_minutes: { raised: 11, from_ms: 1e12 },
    flood_percent: 1,
    raised: 100,
    by_priority: { high: 8, medium: 18, low: 74 },
    chattering: ['a'],
  }
  const names = ['a', 'b', 'c', 'd', 'e']
  for (const [figures, marked] of [
    [{ ...within, long_active: names.slice(1) }, 0],
    [{ ...beyond, long_active: names }, 8],
  ]) {
    await as('vera', async (page) => {
      const panel = await performancePanel(page, figures)
      await panel.getByRole('row', { name: `per hour ${marked ? '12.1 beyond the target' : '12.0'}` }).waitFor()
      const rows = panel.locator('tr[data-beyond]')
      assert.deepEqual(
        [await rows.count(), await rows.filter({ hasText: '▲' }).filter({ hasText: 'beyond the target' }).count()],
        [marked, marked],
      )
      const colours = await panel
        .locator('tbody td:nth-of-type(1), tbody strong')
        .evaluateAll((all) => all.map((one) => getComputedStyle(one).color))
      assert.equal(new Set(colours).size, 1, colours.join('; '))
    })
  }
})

test('the shares of the priorities are judged when there are enough alarms', async () => {
  for (const [high, others, words] of [
    [19, { medium: 0, low: 0 }, ''],
    [10, { medium: 15, low: 75 }, ' beyond the target'],
  ]) {
    await as('vera', async (page) => {
      const figures = { raised: high + others.medium + others.low, by_priority: { high, ...others } }
      const panel = await performancePanel(page, figures)
      await panel.getByRole('row', { name: `alarms ${figures.raised}`, exact: true }).waitFor()
      const row = (priority) => panel.getByRole('row', { name: `of ${priority} priority` })
      const told = async (priority) => (await text(row(priority))).replace(/\s+/g, ' ').trim()
      assert.equal(
        await told('high'),
        words ? `of high priority ▲ 10 %${words} about 5 %` : 'of high priority 100 % about 5 %',
      )
      assert.equal(await told('medium'), `of medium priority ${others.medium} % about 15 %`)
      const low = words ? `▲ 75 %${words}` : '0 %'
      assert.equal(await told('low'), `of low priority ${low} about 80 %`)
      assert.deepEqual(await violations(page), [])
    })
  }
})

test('the header of every page has the number of alarms and the highest priority', async () => {
  await as('vera', async (page) => {
    for (const path of ['/', '/trends', '/bus', '/events']) {
      await page.goto(plant.url + path)
      const badge = page.locator('.badge')
      await badge.waitFor()
      assert.match(await text(badge), /1 \d+ high/)
    }
    await page.locator('.badge').click()
    assert.equal(new URL(page.url()).pathname, '/alarms')
    await page.keyboard.press('1')
    assert.match(await text(page.locator('[data-gauge="gate 2"] .card-alarms')), /1 gate 2 not evacuated/)
    await page.keyboard.press('7')
    await becomes(() => text(page.locator('nav [aria-current]')), 'Alarms')
  })
})

test('several alarms are acknowledged together', async () => {
  await as('olga', async (page) => {
    await page.getByRole('button', { name: /^Acknowledge all \d+$/ }).click()
    await page.waitForFunction(() => !document.querySelector('.alarm-item .alarm-state.unacknowledged'))
    await becomes(() => page.locator('[role=alert]').count(), 0)
  })
})

test('a narrow screen shows all alarms without scrolling sideways', async () => {
  await as(
    'ada',
    async (page) => {
      const [inner, whole] = await page.evaluate(() => [innerWidth, document.documentElement.scrollWidth])
      assert.ok(whole <= inner, `${whole} of ${inner}`)
    },
    { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true },
  )
})

test('the name of a gauge does not break at the end of a line', async () => {
  await as('vera', async (page) => {
    const link = item(page, 'gate 2 not evacuated').getByRole('link', { name: 'gate 2' })
    // At some width the name is at the end of a line.
    for (let width = 320; width < 640; width += 8) {
      await page.setViewportSize({ width, height: 740 })
      const lines = await link.evaluate((one) => {
        const range = document.createRange()
        range.selectNodeContents(one)
        return new Set([...range.getClientRects()].map(({ top }) => top)).size
      })
      assert.equal(lines, 1, `${width} pixels`)
    }
  })
})

test('alarm limits are lines in trends, in the colours of their priorities', async () => {
  await as('vera', async (page) => {
    await page.goto(`${plant.url}/trends?s=transfer&s=gate+2&s=chamber`)
    const limits = page.getByRole('list', { name: 'Alarm limits' })
    await limits.waitFor()
    // A rise limit has no line; the highest priority comes first.
    const told = (await limits.locator('li').allInnerTexts()).map((line) => line.replace(/\s+/g, ' '))
    assert.equal(told.length, 2, `${told}`)
    assert.match(told[0], /^1 high gate 2 not evacuated above .*mbar$/)
    assert.match(told[1], /^3 low transfer above 3e-5 mbar above .*mbar$/)
    await page.waitForFunction(() => {
      const canvas = document.querySelector('.chart canvas')
      const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height)
      const style = getComputedStyle(document.documentElement)
      const found = ['bad', 'low'].map((name) => {
        const [r, g, b] = style.getPropertyValue(`--${name}`).match(/\d+/g).map(Number)
        let count = 0
        for (let place = 0; place < data.length; place += 4)
          if (data[place] === r && data[place + 1] === g && data[place + 2] === b) count += 1
        return count
      })
      return found.every((count) => count > canvas.width / 3)
    })
  })
})

test('only active alarms have colour, on the page of the alarms and below trends', async () => {
  /** The names of the rows and items with an element in a colour of alarms. */
  const coloured = () => {
    const probe = document.body.appendChild(document.createElement('i'))
    const wanted = ['bad', 'warn', 'low', 'bad-pale', 'warn-pale', 'low-pale'].map((name) => {
      probe.style.color = `var(--${name})`
      return getComputedStyle(probe).color
    })
    probe.remove()
    const places = [
      ...document.querySelectorAll('.alarm-item, .all-alarms tbody tr, .alarm-history tbody tr, .limits li'),
    ]
    const isColoured = (element) => {
      const { color, backgroundColor, borderLeftColor } = getComputedStyle(element)
      return [color, backgroundColor, borderLeftColor].some((colour) => wanted.includes(colour))
    }
    const name = (place) =>
      place.dataset.alarm ?? place.dataset.limit ?? place.querySelector('th, td:nth-child(4)').innerText
    return places.filter((place) => [place, ...place.querySelectorAll('*')].some(isColoured)).map(name)
  }
  await as('ada', async (page) => {
    plant.tell('vessel=5e4')
    const vented = item(page, 'vessel vented')
    await vented.waitFor()
    plant.tell('vessel=1')
    await vented.locator('.alarm-state.returned').waitFor()
    await page.getByRole('region', { name: 'All alarms' }).locator('summary').click()
    await page.locator('.all-alarms tr', { hasText: 'vessel vented' }).locator('.alarm-state.returned').waitFor()
    await page.locator('.alarm-history tbody tr').first().waitFor()
    const states = await page.evaluate(async () => (await fetch('/api/alarms')).json())
    const active = states.filter(({ state }) => /^(un)?acknowledged$/.test(state)).map(({ name }) => name)
    assert.ok(active.length > 0 && active.length < states.length)
    assert.deepEqual([...new Set(await page.evaluate(coloured))].sort(), active.sort())
    await page.goto(`${plant.url}/trends?s=vessel`)
    await page.locator('.limits li', { hasText: 'vessel vented' }).waitFor()
    assert.deepEqual(await page.evaluate(coloured), [])
  })
})

test('a screen of 1080 pixels has 38 alarms below the heading of their group, each in one line', async () => {
  const folder = await mkdtemp(join(tmpdir(), 'profivac-list-'))
  let station
  try {
    const file = join(folder, 'plant.toml')
    await writeFile(join(folder, 'line.toml'), 'devices = ["bcg450@5"]\npressure = "2e-4 mbar"\n')
    const alarms = Array.from(
      { length: 40 },
      (_, index) => `[[alarm]]\nname = "limit ${index}"\ngauge = "ion"\nabove = "1e-6 mbar"\ndelay = "0 s"`,
    )
    const line = '[[segment]]\nname = "hall"\nport = "sim:line.toml"\n'
    const gauge = '[[segment.gauge]]\nname = "ion"\naddress = 5\ndevice = "bcg450"'
    await writeFile(file, [line + gauge, ...alarms].join('\n'), { mode: 0o600 })
    await addUser(file, 'olga', 'operator', PASSWORD)
    station = await startStation(file)
    const look = async (page) => {
      await page.setViewportSize({ width: 1920, height: 1080 })
      await becomes(() => page.locator('.alarm-line').count(), 40)
      const bottoms = () =>
        page.locator('.alarm-line').evaluateAll((all) => all.map((one) => one.getBoundingClientRect().bottom))
      await becomes(async () => (await bottoms()).filter((bottom) => bottom <= 1080).length >= 38, true)

      // The first alarm is three keys away.
      await page.reload()
      await becomes(() => page.locator('.alarm-line').count(), 40)
      for (const key of ['Tab', 'Tab', 'Enter']) await page.keyboard.press(key)
      const focused = () => page.evaluate(() => document.activeElement.getAttribute('aria-label'))
      assert.equal(await focused(), 'Acknowledge: limit 0')
      // An acknowledged alarm leaves the focus to the next one, and no alarm moves.
      const before = await page.locator('.alarm-line').evaluateAll((all) => all.map((one) => one.dataset.alarm))
      await page.keyboard.press('Enter')
      await becomes(focused, `Acknowledge: ${before[1]}`)
      await page.keyboard.press('Enter')
      await becomes(focused, `Acknowledge: ${before[2]}`)
      await page.locator('.alarm-line .alarm-state.acknowledged').nth(1).waitFor()
      assert.deepEqual(
        (await page.locator('.alarm-line').evaluateAll((all) => all.map((one) => one.dataset.alarm))).slice(0, 5),
        before.slice(0, 5),
      )

      // Ticked alarms are acknowledged together, and no others.
      for (const name of ['limit 20', 'limit 30']) await page.getByLabel(`Select: ${name}`, { exact: true }).check()
      await page.getByRole('button', { name: 'Acknowledge selected 2' }).click()
      await becomes(() => page.locator('.alarm-line .alarm-state.acknowledged').count(), 4)
      await item(page, 'limit 30').locator('.alarm-state.acknowledged').waitFor()
      assert.ok(await page.getByRole('button', { name: 'Acknowledge selected', exact: true }).isDisabled())

      // In another order the alarms are one list.
      await page.getByLabel('Order').selectOption('alarm')
      await becomes(() => page.locator('.alarm-group').count(), 0)
      const sorted = await page.locator('.alarm-line').evaluateAll((all) => all.map((one) => one.dataset.alarm))
      assert.deepEqual(sorted.slice(0, 3), ['limit 0', 'limit 1', 'limit 10'])
      assert.deepEqual(await violations(page), [])
    }
    await as('olga', look, {}, station)
  } finally {
    await station?.stop()
    await rm(folder, { recursive: true, force: true })
  }
})

/** The file of a station with two volumes and an alarm flood: 62 alarms, more than a snapshot has. Of `ion`, on a line of its own, are 60. */
function flood(port) {
  const gauge = (name, address, location) =>
    `[[segment.gauge]]\nname = "${name}"\naddress = ${address}\ndevice = "bcg450"\nlocation = "${location}"`
  const raised = (name, gauge, priority, delay = '0 s') =>
    `[[alarm]]\nname = "${name}"\ngauge = "${gauge}"\nabove = "1e-6 mbar"\npriority = "${priority}"\ndelay = "${delay}"`
  return [
    '[[segment]]\nname = "hall"\nport = "sim:line.toml"',
    gauge('cold', 6, 'hall'),
    gauge('fore', 7, 'cellar'),
    `[[segment]]\nname = "ion line"\nport = "${port}"`,
    gauge('ion', 5, 'hall'),
    '[[volume]]\nname = "chamber"\ngauges = ["ion", "cold"]\n[[volume]]\nname = "fore line"\ngauges = ["fore"]',
    raised('ion late', 'ion', 'high', '2 s'),
    raised('cold early', 'cold', 'low'),
    ...Array.from({ length: 59 }, (_, index) => raised(`ion ${index}`, 'ion', 'medium', '1 s')),
    raised('fore alone', 'fore', 'low'),
  ].join('\n')
}

test('a flood of alarms has groups by volume, what was first, a filter, and a question before all are acknowledged', async () => {
  const folder = await mkdtemp(join(tmpdir(), 'profivac-flood-'))
  let gauges
  let station
  try {
    gauges = await startGauges('--pressure', '1e-8 mbar', 'bcg450@5')
    const file = join(folder, 'plant.toml')
    const devices = [6, 7].map((address) => `"bcg450@${address}"`)
    await writeFile(join(folder, 'line.toml'), `devices = [${devices}]\npressure = "2e-4 mbar"\n`)
    await writeFile(file, flood(gauges.port), { mode: 0o600 })
    await addUser(file, 'olga', 'operator', PASSWORD)
    station = await startStation(file)
    const look = async (page) => {
      const active = page.getByRole('region', { name: 'Active alarms' })
      const group = active.locator('[data-group="volume chamber"]')
      const said = (pattern) =>
        page.waitForFunction(
          (source) =>
            new RegExp(source).test(document.querySelector('[data-group="volume chamber"] summary')?.innerText),
          pattern,
        )
      // The alarm that is first is there before the pressure rises at the other gauge; the most urgent one is raised last.
      await item(page, 'cold early').waitFor()
      gauges.tell('pressure 2e-4 mbar')
      await said('^chamber\\s+1 1 high, 59 medium, 1 low, 61 not acknowledged · first of the active ones: cold early$')
      await active.getByRole('button', { name: 'Acknowledge all 62' }).waitFor()
      const inList = await active
        .locator('.alarm-list')
        .first()
        .evaluate((list) => [...list.children].map(({ dataset }) => dataset.group ?? dataset.alarm))
      assert.deepEqual(inList, ['volume chamber', 'fore alone'])
      // A long list is closed. The user opens and closes groups, with the keyboard too.
      await becomes(() => item(page, 'cold early').count(), 0)
      await group.locator('summary').focus()
      await page.keyboard.press('Enter')
      await item(page, 'cold early').waitFor()
      await becomes(() => group.locator('.alarm-item').count(), 61)
      const first = await group.locator('.alarm-item').first().getAttribute('data-alarm')
      assert.equal(first, 'ion late')
      const lefts = await active
        .locator('button.acknowledge')
        .evaluateAll((all) => all.map((one) => one.getBoundingClientRect().left))
      assert.deepEqual([lefts.length, new Set(lefts).size], [62, 1])
      assert.deepEqual(await violations(page), [])
      await page.keyboard.press('Enter')
      await item(page, 'cold early').waitFor({ state: 'detached' })

      // The filter: text of the location, then a priority. The buttons concern what passes.
      const search = active.getByLabel('Search active alarms')
      await search.fill('cellar')
      await active.getByRole('status').getByText('1 of 62 alarms').waitFor()
      await becomes(() => group.count(), 0)
      await active.getByRole('button', { name: 'Acknowledge all 1' }).waitFor()
      await active.getByRole('button', { name: 'Shelve all 1 …' }).waitFor()
      await search.fill('')
      await active.getByLabel('Priority').selectOption('low')
      await active.getByRole('status').getByText('2 of 62 alarms').waitFor()
      await active.getByRole('button', { name: 'Shelve all 2 …' }).waitFor()
      // Two alarms that are both in sight need no question.
      await active.getByRole('button', { name: 'Acknowledge all 2' }).click()
      await page.waitForFunction(() => document.querySelectorAll('.alarm-item .alarm-state.acknowledged').length === 2)
      await becomes(() => page.getByRole('dialog').count(), 0)

      // Alarms in a closed group are named before they are acknowledged.
      await active.getByLabel('Priority').selectOption('')
      await search.fill('7')
      await active.getByRole('status').getByText('6 of 62 alarms').waitFor()
      const six = active.getByRole('button', { name: 'Acknowledge all 6' })
      await six.click()
      const dialog = page.getByRole('dialog')
      await dialog.locator('li').nth(5).waitFor()
      assert.deepEqual(
        (await dialog.locator('li').allInnerTexts()).map((line) => line.replace(/\s+/g, ' ')).sort(),
        [17, 27, 37, 47, 57, 7].map((number) => `2 medium ion ${number}`),
      )
      await page.waitForFunction(() => document.activeElement?.classList.contains('names'))
      assert.deepEqual(await violations(page), [])
      await page.keyboard.press('Escape')
      await dialog.waitFor({ state: 'detached' })
      await said('6 not acknowledged')
      await six.click()
      await dialog.getByRole('button', { name: 'Acknowledge all 6' }).click()
      await said('6 medium · first of the active ones: cold early$')
      await search.fill('')
      await said('59 medium, 1 low, 54 not acknowledged')

      // So many alarms are named also where their group is open.
      await group.locator('summary').click()
      await active.getByRole('button', { name: 'Acknowledge all 54' }).click()
      await dialog.locator('li').nth(53).waitFor()
      await becomes(() => dialog.locator('li').count(), 54)
    }
    await as('olga', look, {}, station)
  } finally {
    await station?.stop()
    await gauges?.stop()
    await rm(folder, { recursive: true, force: true })
  }
})
