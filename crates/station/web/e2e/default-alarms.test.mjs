// The default alarms in a browser: an engineer changes one, and the running alarms follow.

import assert from 'node:assert/strict'
import { after, before, test } from 'node:test'
import { violations } from './axe.mjs'
import { becomes, openContext, startBrowser, startPlant } from './setup.mjs'

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

/** Shows a user the default alarms after the login. */
async function as(name, look) {
  const { page, complaints, close } = await openContext(browser)
  try {
    await page.goto(`${plant.url}/alarms`)
    await page.getByLabel('Name').fill(name)
    await page.getByLabel('Password', { exact: true }).fill(PASSWORD)
    await page.getByLabel('Password', { exact: true }).press('Enter')
    const panel = page.getByRole('region', { name: 'Default alarms' })
    await panel.locator('summary').click()
    await panel.getByRole('row', { name: /^stale/ }).waitFor()
    await look(page, panel)
    // Chromium reports a refused request as an error on the console.
    assert.deepEqual(
      complaints.filter((complaint) => !/status of 400/.test(complaint)),
      [],
    )
  } finally {
    await close()
  }
}

test('an engineer changes the default alarms about missing data', async () => {
  await as('ada', async (page, panel) => {
    const row = panel.getByRole('row', { name: /^stale/ })
    assert.match(await row.innerText(), /A gauge delivers no new data\.\s+low, after 0 s, ends after 2 s/)
    await row.getByRole('button', { name: 'Settings: stale' }).click()
    const dialog = page.getByRole('dialog', { name: 'Default alarm settings' })
    await becomes(() => dialog.getByLabel('Delay', { exact: true }).inputValue(), '0 s')
    await becomes(() => dialog.getByLabel('Off-delay').getAttribute('placeholder'), '2 s')
    assert.deepEqual(await violations(page), [])
    await dialog.getByLabel('Reason').fill('The spare gauge is not installed.')
    // A refused value stays in the dialog, with the sentence of the station.
    await dialog.getByLabel('Except these gauges').fill('spar')
    await dialog.getByRole('button', { name: 'Change' }).click()
    assert.match(await dialog.getByRole('alert').innerText(), /there is no gauge "spar"; did you mean "spare"\?/)
    await dialog.getByLabel('Except these gauges').fill('spare')
    await dialog.getByLabel('Priority').selectOption('medium')
    await dialog.getByRole('button', { name: 'Change' }).click()
    await dialog.waitFor({ state: 'detached' })
    await panel.getByText('medium, after 0 s, ends after 2 s, except spare').waitFor()
    await page.locator('[data-alarm="spare: no data"]').waitFor({ state: 'detached' })
    await page.goto(`${plant.url}/audit`)
    const entry = page.locator('tbody tr').filter({ hasText: '[alarms] stale' }).first()
    await entry.waitFor()
    assert.match(await entry.innerText(), /settings.*delay = "0 s".*except = \["spare"\].*is not installed\./s)
  })
})

test('an operator sees the default alarms and does not change them', async () => {
  await as('olga', async (_, panel) => {
    await becomes(() => panel.getByRole('button').count(), 0)
    await becomes(() => panel.getByRole('row').count(), 8)
  })
})
