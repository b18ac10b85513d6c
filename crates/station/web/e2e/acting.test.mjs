// Acting as people do it: in a browser, over a real segment in memory. Nothing waits for a time, everything for a condition.

import assert from 'node:assert/strict'
import { after, before, test } from 'node:test'
import { drawn, openPage, startActing, startBrowser } from './desk.mjs'

const OPERATOR = 'Otto'
const ENGINEER = 'Erna'
const VIEWER = 'Vera'

let browser
let plant

/** The cookie of everybody, and the token that goes with it. */
const sessions = new Map()

async function login(name) {
  const headers = { 'content-type': 'application/json' }
  const body = JSON.stringify({ name, password: 'tin whisker plateau' })
  const answer = await fetch(`${plant.url}/api/login`, { method: 'POST', headers, body })
  const [, cookie, value] = /^([^=]+)=([^;]+)/.exec(answer.headers.get('set-cookie'))
  return { cookie, value, token: (await answer.json()).token }
}

/** Asks the API as somebody. */
function ask(person, path, method = 'GET') {
  const { cookie, value, token } = sessions.get(person)
  return fetch(plant.url + path, { method, headers: { cookie: `${cookie}=${value}`, 'x-csrf-token': token } })
}

before(async () => {
  ;[browser, plant] = await Promise.all([startBrowser(), startActing()])
  for (const person of [OPERATOR, ENGINEER, VIEWER]) sessions.set(person, await login(person))
})

after(async () => {
  await browser?.close()
  await plant?.stop()
})

/** A refusal is an answer that the console calls an error. */
const REFUSAL = /the server responded with a status of 4\d\d/

/** Opens a page as somebody, and afterwards holds it to have complained of nothing but refusals. */
async function as(person, path, look, options = {}) {
  const { cookie, value } = sessions.get(person)
  const storageState = {
    cookies: [
      {
        name: cookie,
        value,
        domain: '127.0.0.1',
        path: '/',
        expires: -1,
        httpOnly: true,
        secure: false,
        sameSite: 'Strict',
      },
    ],
    origins: [],
  }
  const { page, complaints, close } = await openPage(browser, plant.url + path, { storageState, ...options })
  try {
    await look(page)
    assert.deepEqual(
      complaints.filter((complaint) => !REFUSAL.test(complaint)),
      [],
    )
  } finally {
    await close()
  }
}

const text = (locator) => locator.innerText()
const command = (page, name) => page.locator(`[data-command="${name}"] button`)
const panel = (page) => page.getByRole('dialog', { name: 'Order' })

/** Has the mastership, whoever had it. */
async function masters(person) {
  await ask(ENGINEER, '/api/mastership/take-over', 'POST')
  await ask(ENGINEER, '/api/mastership/release', 'POST')
  await ask(person, '/api/mastership/ask', 'POST')
}

/** The pressure in the chamber, and the gauge has seen it. */
async function pressure(mbar) {
  plant.tell(`mbar ${mbar}`)
  for (;;) {
    const [{ readings }] = await (await ask(VIEWER, '/api/gauges')).json()
    if (readings[0]?.pa && Math.abs(readings[0].pa / (mbar * 100) - 1) < 0.1) return
  }
}

test('somebody reads, plots, arms a degas and fires it', async () => {
  await pressure(1e-6)
  await masters(ENGINEER)
  await ask(ENGINEER, '/api/mastership/release', 'POST')
  await as(OPERATOR, '/', async (page) => {
    await page.locator('.big', { hasText: '× 10⁻⁶ mbar' }).waitFor()
    await page.keyboard.press('2')
    await drawn(page)
    await page.goto(`${plant.url}/gauge/chamber`)
    await page.locator('.mastership', { hasText: 'Nobody acts' }).waitFor()
    assert.equal(await command(page, 'ba.degas-on').isDisabled(), true)
    await page.locator('.mastership').getByRole('button', { name: 'Ask' }).click()
    await page.locator('.mastership', { hasText: 'You act' }).waitFor()
    await command(page, 'ba.degas-on').click()
    await panel(page).getByRole('button', { name: 'Fire' }).waitFor()
    assert.equal(await panel(page).locator('.conditions .holds').count(), 3)
    const said = await text(panel(page))
    assert.match(said, /heats the electrodes/)
    assert.match(said, /ba\.process-value is below 7\.2e-6 mbar · it is 1e-6 mbar/)
    assert.match(said, /armed for \d+ s/)
    await panel(page).getByRole('button', { name: 'Fire' }).click()
    await panel(page).getByText('Done: ba.degas-on').waitFor()
    await panel(page).getByRole('button', { name: 'Close' }).click()
    await page.keyboard.press('8')
    const rows = page.locator('.audit tbody tr')
    await rows.filter({ hasText: 'degas-on' }).first().waitFor()
    assert.match(
      await text(rows.first()),
      /Otto operator, 127\.0\.0\.1[^]*outcome[^]*chamber 5[^]*Hot Cathode Block State Command \(1:2\/14\)[^]*done/,
    )
    await page.keyboard.press('6')
    await page.locator('.events tbody tr', { hasText: 'ba.degas-on by Otto: done' }).waitFor()
  })
})

test('a degas above its pressure is refused with the condition', async () => {
  await pressure(5e-4)
  await masters(OPERATOR)
  await as(OPERATOR, '/gauge/chamber', async (page) => {
    await command(page, 'ba.degas-on').click()
    await panel(page).locator('.alarm', { hasText: 'must be below 7.2e-6 mbar; pump down first' }).waitFor()
    assert.match(
      await text(panel(page).locator('.conditions .fails').last()),
      /ba\.process-value is below 7\.2e-6 mbar · it is 5e-4 mbar/,
    )
    assert.equal(await panel(page).getByRole('button', { name: 'Fire' }).count(), 0)
    await page.keyboard.press('1')
    assert.equal(new URL(page.url()).pathname, '/gauge/chamber', 'a key that slipped leads away from an order')
  })
  await pressure(1e-6)
})

test('a viewer sees what there is and why not', async () => {
  await as(VIEWER, '/gauge/chamber', async (page) => {
    await page.locator('.commands .permission', { hasText: 'Commands need the role operator' }).waitFor()
    await page.locator('.parameters').first().waitFor()
    assert.equal(await page.locator('.commands li button:enabled').count(), 0)
    assert.equal(await page.getByRole('button', { name: /^Change/ }).count(), 0)
    assert.equal(await page.locator('.mastership button').count(), 0)
    assert.match(await text(page.locator('[data-command="ba.degas-on"]')), /needs the role operator/)
  })
})

test('a parameter is changed by keys alone', async () => {
  await masters(ENGINEER)
  await as(ENGINEER, '/gauge/chamber', async (page) => {
    const row = page.locator('[data-target="pirani.safe-state"]')
    await row.getByRole('button', { name: 'Change Safe State' }).focus()
    await page.keyboard.press('Enter')
    await row.getByRole('combobox').focus()
    await row.getByRole('combobox').selectOption('hold-last-value')
    await page.keyboard.press('Tab')
    await page.keyboard.press('Enter')
    await panel(page).getByRole('button', { name: 'Fire' }).waitFor()
    assert.match(await text(panel(page).locator('.what')), /zero → hold-last-value/)
    await page.waitForFunction(() => document.activeElement?.textContent === 'Disarm')
    await page.keyboard.press('Shift+Tab')
    await page.keyboard.press('Enter')
    await panel(page).getByText('was zero and reads hold-last-value').waitFor()
    await page.keyboard.press('Escape')
    await panel(page).waitFor({ state: 'hidden' })
    await row.locator('.value', { hasText: 'hold-last-value' }).waitFor()
  })
})

test('what a gauge or its table does not take is said in words', async () => {
  await masters(ENGINEER)
  await as(ENGINEER, '/gauge/chamber', async (page) => {
    const row = page.locator('[data-target="pirani.safe-value"]')
    await row.getByRole('button', { name: 'Change Safe Value' }).click()
    assert.match(await text(row.locator('.takes')), /a pressure of 0 mbar or more/)
    await row.getByRole('textbox').fill('-1')
    await row.getByRole('button', { name: 'Arm' }).click()
    await panel(page).locator('.alarm', { hasText: 'expected a pressure of 0 mbar or more, got "-1"' }).waitFor()
    await panel(page).getByRole('button', { name: 'Close' }).click()
    const unit = page.locator('[data-target="pirani.data-units"] details')
    await unit.getByText('not from here').click()
    assert.match(await text(unit), /the station reads the cyclic data/)
  })
})

test('the mastership goes from one to another, and disarms', async () => {
  await masters(OPERATOR)
  await as(OPERATOR, '/gauge/chamber', async (otto) => {
    await command(otto, 'ba.degas-off').click()
    await panel(otto).getByRole('button', { name: 'Fire' }).waitFor()
    await as(ENGINEER, '/', async (erna) => {
      const mark = erna.locator('.mastership')
      await mark.getByText('Otto acts').waitFor()
      await mark.getByRole('button', { name: 'Ask' }).click()
      await mark.getByText('Otto acts, you have asked').waitFor()
      await otto.locator('.mastership', { hasText: 'You act, Erna asks' }).waitFor()
      await mark.getByRole('button', { name: 'Take over' }).click()
      await mark.getByText('You act').waitFor()
    })
    await panel(otto).getByRole('button', { name: 'Fire' }).click()
    await panel(otto).locator('.alarm', { hasText: 'was disarmed when the mastership changed hands' }).waitFor()
    await panel(otto).getByRole('button', { name: 'Close' }).click()
    await otto.locator('.mastership', { hasText: 'Erna acts' }).waitFor()
  })
})

test('the audit page filters, and gives a table', async () => {
  await as(VIEWER, '/audit', async (page) => {
    const rows = page.locator('.audit tbody tr')
    await rows.first().waitFor()
    await page.getByLabel('Who').fill('Erna')
    await page.waitForFunction(() =>
      [...document.querySelectorAll('.audit tbody tr')].every((row) => row.innerText.includes('Erna')),
    )
    const table = await (await ask(VIEWER, await page.getByRole('link', { name: 'CSV' }).getAttribute('href'))).text()
    assert.match(table, /^id,time,what,of,who/)
    assert.ok(
      table
        .trim()
        .split('\n')
        .slice(1)
        .every((line) => line.includes('"Erna"')),
    )
  })
})
