// A declared plant state in a browser: which alarms it suppresses, where that is seen, and what each role may do.

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

/** Shows a user the alarms page after the login. */
async function as(name, look, options = {}) {
  const { page, complaints, close } = await openContext(browser, options)
  try {
    await page.goto(`${plant.url}/alarms`)
    await page.getByLabel('Name').fill(name)
    await page.getByLabel('Password', { exact: true }).fill(PASSWORD)
    await page.getByLabel('Password', { exact: true }).press('Enter')
    await page.locator('[data-plant-state]').first().waitFor()
    await look(page)
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
}

const state = (page, name) => page.locator(`[data-plant-state="${name}"]`)
const active = (page, name) => page.getByRole('region', { name: 'Active alarms' }).locator(`[data-alarm="${name}"]`)
const mark = (page) => page.getByRole('banner').getByRole('link', { name: /^Plant state/ })

test('a declared plant state suppresses its alarms until an operator ends it', async () => {
  await as('olga', async (page) => {
    plant.tell('vessel=5e4')
    await active(page, 'vessel vented').waitFor()
    await becomes(() => mark(page).count(), 0)
    await state(page, 'Vented').getByRole('button', { name: 'Declare: Vented' }).click()
    const dialog = page.getByRole('dialog')
    assert.match(await dialog.innerText(), /suppresses 2 alarms until its end/)
    await dialog.getByRole('button', { name: 'Declare' }).click()
    assert.ok(await dialog.isVisible(), 'the form is sent without a reason')
    await dialog.getByLabel('Reason').fill('The target is changed.')
    const durations = await dialog.getByLabel('Duration').locator('option').allInnerTexts()
    assert.deepEqual(durations, ['30 minutes', '1 hour', '4 hours', '8 hours', '12 hours'])
    await dialog.getByLabel('Duration').selectOption({ label: '4 hours' })
    await dialog.getByRole('button', { name: 'Declare' }).click()
    await active(page, 'vessel vented').waitFor({ state: 'detached' })
    await mark(page).waitFor()
    assert.match(await mark(page).innerText(), /Vented/)
    assert.deepEqual(await violations(page), [])
    const vented = page.locator('[data-plant-state="Vented"].declared')
    await vented.waitFor()
    assert.match(await vented.innerText(), /Reason: The target is changed\.\s+olga, .*, until /)
    const suppressed = page.getByRole('region', { name: 'Suppressed' })
    await suppressed.getByText('Suppressed: 2').click()
    const item = suppressed.locator('[data-alarm="vessel vented"]')
    assert.match(await item.innerText(), /suppressed\s+vessel vented\s+Vented: The target is changed\./)
    await vented.getByRole('button', { name: 'Extend: Vented' }).click()
    await dialog.getByLabel('Reason').fill('The target is not there yet.')
    await dialog.getByLabel('Duration').selectOption({ label: '12 hours' })
    await dialog.getByRole('button', { name: 'Extend' }).click()
    await vented.getByText('The target is not there yet.').waitFor()
    await page.goto(`${plant.url}/wall`)
    await page.locator('.wall-head').getByText('Plant state: Vented · 2 suppressed').waitFor()
    await page.goto(`${plant.url}/alarms`)
    await vented.getByRole('button', { name: 'End: Vented', exact: true }).click()
    await dialog.getByRole('button', { name: 'End', exact: true }).click()
    await active(page, 'vessel vented').waitFor()
    assert.match(await active(page, 'vessel vented').innerText(), /1 high\s+not acknowledged/)
    await mark(page).waitFor({ state: 'detached' })
    await suppressed.waitFor({ state: 'detached' })
    plant.tell('vessel=1')
    await active(page, 'vessel vented').getByRole('button', { name: 'Acknowledge' }).click()
    await active(page, 'vessel vented').waitFor({ state: 'detached' })
    await page.goto(`${plant.url}/audit`)
    const rows = page.getByRole('region', { name: 'Audit' }).locator('tbody tr', { hasText: 'plant state' })
    await rows.nth(2).waitFor()
    const actions = await rows.evaluateAll((rows) => rows.map((row) => row.cells[2].innerText))
    assert.deepEqual(actions, ['plant state ended', 'plant state extended', 'plant state declared'])
  })
})

test('a viewer sees the plant states and has no buttons, an operator none for an engineer', async () => {
  const buttons = (page, name) => state(page, name).getByRole('button').allInnerTexts()
  await as('vera', async (page) => {
    assert.match(await state(page, 'Vented').innerText(), /Vented not declared\s+The vessel is open to air\./)
    assert.deepEqual([await buttons(page, 'Vented'), await buttons(page, 'Bake-out')], [[], []])
  })
  await as('olga', async (page) => {
    assert.deepEqual([await buttons(page, 'Vented'), await buttons(page, 'Bake-out')], [['Declare …'], []])
  })
  await as('ada', async (page) => {
    assert.deepEqual(await buttons(page, 'Bake-out'), ['Declare …'])
  })
})

test('the dialog of a plant state names its alarms, active ones first, and all of them on request', async () => {
  await as('olga', async (page) => {
    const [states, names] = await page.evaluate(async () => {
      const get = async (path) => (await fetch(path)).json()
      return [await get('/api/plant-states'), (await get('/api/alarms')).map(({ name }) => name)]
    })
    const json = states.map((state) => ({ ...state, alarms: names }))
    await page.route('**/api/plant-states', (route) => route.fulfill({ json }))
    // The plant states are fetched every ten seconds.
    await state(page, 'Vented').getByText(`would suppress ${names.length} alarms`).waitFor()
    await state(page, 'Vented').getByRole('button', { name: 'Declare: Vented' }).click()
    const dialog = page.getByRole('dialog')
    const first = dialog.locator('.alarm-names').first().getByRole('listitem')
    await first.filter({ hasText: /gate 2 not evacuated\s+active/ }).waitFor()
    await becomes(() => first.count(), 8)
    assert.match(await first.first().innerText(), /^1\s+high\s+gate 2 not evacuated\s+active$/)
    const more = dialog.getByText(`and ${names.length - 8} more`)
    await more.focus()
    await page.keyboard.press('Enter')
    await dialog
      .getByRole('listitem')
      .nth(names.length - 1)
      .waitFor()
    const listed = await dialog.innerText()
    for (const name of names) assert.ok(listed.includes(name), name)
    assert.equal(
      await dialog.getByRole('listitem').filter({ hasText: 'cryostat above' }).getByText('active').count(),
      0,
    )
    assert.deepEqual(await violations(page), [])
  })
})

test('the plant states and their dialog are accessible, on a phone too', async () => {
  for (const viewport of [
    { width: 1280, height: 800 },
    { width: 390, height: 800 },
  ]) {
    await as(
      'olga',
      async (page) => {
        await state(page, 'Vented').getByRole('button', { name: 'Declare: Vented' }).click()
        await page.getByRole('dialog').waitFor()
        assert.deepEqual(await violations(page), [])
        const [wide, shown] = await page.evaluate(() => [document.body.scrollWidth, window.innerWidth])
        assert.ok(wide <= shown, `${wide} of ${shown}`)
      },
      { viewport },
    )
  }
})
