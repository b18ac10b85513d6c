// Commands and parameters in a browser, over a segment in memory. Tests wait for conditions, never for a time.

import assert from 'node:assert/strict'
import { after, before, test } from 'node:test'
import { becomes, drawn, openPage, startActing, startBrowser } from './setup.mjs'

const OPERATOR = 'Otto'
const ENGINEER = 'Erna'
const VIEWER = 'Vera'

let browser
let plant

/** The session of each user: its cookie and its CSRF token. */
const sessions = new Map()

async function login(name) {
  const headers = { 'content-type': 'application/json' }
  const body = JSON.stringify({ name, password: 'tin whisker plateau' })
  const answer = await fetch(`${plant.url}/api/login`, { method: 'POST', headers, body })
  const [, cookie, value] = /^([^=]+)=([^;]+)/.exec(answer.headers.get('set-cookie'))
  return { cookie, value, token: (await answer.json()).token }
}

/** Sends a request to the API as a user. */
function ask(user, path, method = 'GET') {
  const { cookie, value, token } = sessions.get(user)
  return fetch(plant.url + path, { method, headers: { cookie: `${cookie}=${value}`, 'x-csrf-token': token } })
}

before(async () => {
  ;[browser, plant] = await Promise.all([startBrowser(), startActing()])
  for (const user of [OPERATOR, ENGINEER, VIEWER]) sessions.set(user, await login(user))
})

after(async () => {
  await browser?.close()
  await plant?.stop()
})

/** Chromium reports a refused request as an error on the console. */
const REFUSAL = /the server responded with a status of 4\d\d/

/** Opens a page as a user. Refused requests are the only errors that the console may show. */
async function as(user, path, look, options = {}) {
  const { cookie, value } = sessions.get(user)
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
const dialog = (page) => page.getByRole('dialog', { name: /^(Command|Change of a parameter)$/ })

/** Gives control to a user. */
async function giveControl(user) {
  await ask(ENGINEER, '/api/control-authority/take-over', 'POST')
  await ask(ENGINEER, '/api/control-authority/release', 'POST')
  await ask(user, '/api/control-authority/request', 'POST')
}

/** Sets the pressure in the chamber, and waits until the gauge shows it. */
async function pressure(mbar) {
  plant.tell(`mbar ${mbar}`)
  for (;;) {
    const [{ readings }] = await (await ask(VIEWER, '/api/gauges')).json()
    if (readings[0]?.pa && Math.abs(readings[0].pa / (mbar * 100) - 1) < 0.1) return
  }
}

test('an operator looks at trends, requests control, arms a degas and sends it', async () => {
  await pressure(1e-6)
  await giveControl(ENGINEER)
  await ask(ENGINEER, '/api/control-authority/release', 'POST')
  await as(OPERATOR, '/', async (page) => {
    await page.locator('.big', { hasText: '× 10⁻⁶ mbar' }).waitFor()
    await page.keyboard.press('2')
    await drawn(page)
    await page.goto(`${plant.url}/gauge/chamber`)
    await page.locator('.control', { hasText: 'No one has control' }).waitFor()
    await becomes(() => command(page, 'ba.degas-on').isDisabled(), true)
    await page.locator('.control').getByRole('button', { name: 'Request control' }).click()
    await page.locator('.control', { hasText: 'You have control' }).waitFor()
    await command(page, 'ba.degas-on').click()
    await dialog(page).getByRole('button', { name: 'Send' }).waitFor()
    await becomes(() => dialog(page).locator('.conditions .met').count(), 4)
    const said = await text(dialog(page))
    assert.match(said, /heats the electrodes/)
    assert.match(said, /ba\.process-value is below 7\.20 × 10⁻⁶ mbar · it is 1\.00 × 10⁻⁶ mbar/)
    assert.match(said, /armed for \d+ s/)
    await dialog(page).getByRole('button', { name: 'Send' }).click()
    await dialog(page).getByText('Done: ba.degas-on').waitFor()
    await dialog(page).getByRole('button', { name: 'Close' }).click()
    // The state stands beside the commands, read again after the command.
    await page.locator('[data-state="ba.degas-status"] strong', { hasText: 'on' }).waitFor()
    await page.keyboard.press('8')
    const rows = page.locator('.audit tbody tr')
    await rows.filter({ hasText: 'degas-on' }).first().waitFor()
    assert.match(
      await text(rows.first()),
      /Otto operator, 127\.0\.0\.1.*outcome.*chamber address 5.*Hot Cathode Block State Command \(1:2\/14\).*done/s,
    )
    await page.keyboard.press('6')
    await page.locator('.events tbody tr', { hasText: 'ba.degas-on by Otto: done' }).waitFor()
  })
})

test('a degas above its pressure limit is refused with the condition', async () => {
  await pressure(5e-4)
  await giveControl(OPERATOR)
  await as(OPERATOR, '/gauge/chamber', async (page) => {
    await command(page, 'ba.degas-on').click()
    await dialog(page).locator('.error', { hasText: 'must be below 7.2e-6 mbar; pump down first' }).waitFor()
    assert.match(
      await text(dialog(page).locator('.conditions .unmet').last()),
      /ba\.process-value is below 7\.20 × 10⁻⁶ mbar · it is 5\.00 × 10⁻⁴ mbar/,
    )
    await becomes(() => dialog(page).getByRole('button', { name: 'Send' }).count(), 0)
    await page.keyboard.press('1')
    assert.equal(new URL(page.url()).pathname, '/gauge/chamber', 'a shortcut leads away from an open dialog')
  })
  await pressure(1e-6)
})

test('a viewer sees all commands and the role they need', async () => {
  await as(VIEWER, '/gauge/chamber', async (page) => {
    await page.locator('.commands .permission', { hasText: 'Commands need the role operator' }).waitFor()
    await page.locator('.parameters').first().waitFor()
    await becomes(() => page.locator('.commands li button:enabled').count(), 0)
    await becomes(() => page.getByRole('button', { name: /^Change/ }).count(), 0)
    await becomes(() => page.locator('.control button').count(), 0)
    assert.match(await text(page.locator('[data-command="ba.degas-on"]')), /needs the role operator/)
  })
})

test('a parameter is changed with the keyboard alone', async () => {
  await giveControl(ENGINEER)
  await as(ENGINEER, '/gauge/chamber', async (page) => {
    const row = page.locator('[data-target="pirani.safe-state"]')
    await row.getByRole('button', { name: 'Change Safe State' }).focus()
    await page.keyboard.press('Enter')
    await row.getByRole('combobox').focus()
    await row.getByRole('combobox').selectOption('hold-last-value')
    await page.keyboard.press('Tab')
    await page.keyboard.press('Enter')
    await dialog(page).getByRole('button', { name: 'Send' }).waitFor()
    assert.match(await text(dialog(page).locator('.details')), /zero → hold-last-value/)
    await page.waitForFunction(() => document.activeElement?.textContent === 'Disarm')
    await page.keyboard.press('Shift+Tab')
    await page.keyboard.press('Enter')
    await dialog(page).getByText('was zero and reads hold-last-value').waitFor()
    await page.keyboard.press('Escape')
    await dialog(page).waitFor({ state: 'hidden' })
    await row.locator('.value', { hasText: 'hold-last-value' }).waitFor()
  })
})

test('a value that the gauge does not accept is refused with the reason', async () => {
  await giveControl(ENGINEER)
  await as(ENGINEER, '/gauge/chamber', async (page) => {
    const row = page.locator('[data-target="pirani.safe-value"]')
    await row.getByRole('button', { name: 'Change Safe Value' }).click()
    assert.match(await text(row.locator('.takes')), /a pressure of 0 or more with its unit, such as '1500 mbar'/)
    await row.getByRole('textbox').fill('-1')
    await row.getByRole('button', { name: 'Arm' }).click()
    await dialog(page).locator('.error', { hasText: 'a pressure of 0 or more with its unit' }).waitFor()
    await dialog(page).getByRole('button', { name: 'Close' }).click()
    const unit = page.locator('[data-target="pirani.data-units"] details')
    await unit.getByText('cannot be changed here').click()
    assert.match(await text(unit), /the station reads the cyclic data/)
  })
})

test('a change of control disarms commands', async () => {
  await giveControl(OPERATOR)
  await as(OPERATOR, '/gauge/chamber', async (otto) => {
    await command(otto, 'ba.degas-off').click()
    await dialog(otto).getByRole('button', { name: 'Send' }).waitFor()
    await as(ENGINEER, '/', async (erna) => {
      const mark = erna.locator('.control')
      await mark.getByText('Otto has control').waitFor()
      await mark.getByRole('button', { name: 'Request control' }).click()
      await mark.getByText('Otto has control, you have requested it').waitFor()
      await otto.locator('.control', { hasText: 'You have control, Erna requests it' }).waitFor()
      await mark.getByRole('button', { name: 'Take control' }).click()
      await mark.getByText('You have control').waitFor()
    })
    await dialog(otto).getByRole('button', { name: 'Send' }).click()
    await dialog(otto).locator('.error', { hasText: 'was disarmed when its user lost control' }).waitFor()
    await dialog(otto).getByRole('button', { name: 'Close' }).click()
    await otto.locator('.control', { hasText: 'Erna has control' }).waitFor()
  })
})

test('the audit trail is filtered, and saved as CSV', async () => {
  await as(VIEWER, '/audit', async (page) => {
    const rows = page.locator('.audit tbody tr')
    await rows.first().waitFor()
    await page.getByLabel('User', { exact: true }).fill('Erna')
    await page.waitForFunction(() =>
      [...document.querySelectorAll('.audit tbody tr')].every((row) => row.innerText.includes('Erna')),
    )
    const table = await (await ask(VIEWER, await page.getByRole('link', { name: 'CSV' }).getAttribute('href'))).text()
    assert.match(table, /^id,time,action,refers_to,user/)
    assert.ok(
      table
        .trim()
        .split('\n')
        .slice(1)
        .every((line) => line.includes('"Erna"')),
    )
  })
})
