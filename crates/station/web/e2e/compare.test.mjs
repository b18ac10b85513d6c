// The settings of two gauges compared, and one taken over: a plant with two virtual gauges of the same model and one of another.

import assert from 'node:assert/strict'
import { mkdtemp, rm, writeFile } from 'node:fs/promises'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after, before, test } from 'node:test'
import { becomes, openPage, startBrowser, startLastingDemo } from './setup.mjs'

let browser
let station
let folder

const SCENARIO = `title = "Two gauges of a model"
seed = 1
until = "1 h"

[volumes]
chamber = { volume = "20 l", pressure = "1e-2 mbar" }

[gauges]
"pcg550@5" = "chamber"
"pcg550@6" = "chamber"
"bcg450@7" = "chamber"
`

before(async () => {
  folder = await mkdtemp(join(tmpdir(), 'profivac-compare-'))
  const file = join(folder, 'two.toml')
  await writeFile(file, SCENARIO)
  ;[browser, station] = await Promise.all([startBrowser(), startLastingDemo('--scenario', file)])
})

after(async () => {
  await browser?.close()
  await station?.stop()
  await rm(folder, { recursive: true, force: true })
})

const dialog = (page) => page.getByRole('dialog', { name: 'Change of a parameter' })

/** Sends the change that is armed. */
async function send(page) {
  await dialog(page).getByRole('button', { name: 'Send' }).click()
  await dialog(page)
    .getByText('Done: ')
    .or(dialog(page).getByText(/was .* and reads/))
    .first()
    .waitFor()
  await page.keyboard.press('Escape')
  await dialog(page).waitFor({ state: 'hidden' })
}

test('a setting that differs from another gauge of the model is taken over, and the audit trail has it', async () => {
  const { page, complaints, close } = await openPage(browser, `${station.url}/gauge/pcg550%205`)
  try {
    await page.locator('header').getByRole('button', { name: 'Request control' }).click()
    const row = page.locator('[data-target="pirani.safe-state"]')
    await row.getByRole('button', { name: 'Change Safe State' }).click()
    await row.getByRole('combobox').selectOption('hold-last-value')
    await row.getByRole('button', { name: 'Arm' }).click()
    await send(page)

    await page.goto(`${station.url}/gauge/pcg550%206`)
    const choice = page.getByLabel('Compare settings with')
    await choice.waitFor()
    await becomes(() => choice.locator('option').allInnerTexts(), ['Compare settings with …', 'pcg550 5'])
    await choice.selectOption('pcg550 5')
    const comparison = page.getByRole('region', { name: 'Settings beside those of pcg550 5' })
    await comparison.getByText(/^1 of \d\d settings differ\.$/).waitFor()
    const found = comparison.locator('[data-difference]')
    await becomes(() => found.locator('td').allInnerTexts(), ['zero', 'hold-last-value', 'Take over …'])
    // A phone has no head of the table, so each value has the name of its gauge.
    await page.setViewportSize({ width: 360, height: 740 })
    const names = await found
      .locator('td.value')
      .evaluateAll((cells) => cells.map((it) => getComputedStyle(it, '::before').content))
    assert.deepEqual(names, ['"pcg550 6: "', '"pcg550 5: "'])
    await page.setViewportSize({ width: 1280, height: 800 })
    await found.getByRole('button', { name: 'Take over Safe State' }).click()
    await send(page)
    await comparison.getByText(/^All \d\d settings are the same\.$/).waitFor()
    await becomes(() => found.count(), 0)

    const rows = await station.json('/api/audit?gauge=pcg550+6')
    const told = rows.filter(({ target }) => target?.startsWith('Safe State'))
    assert.deepEqual(
      told.map(({ action, before, after }) => [action, before, after]),
      [
        ['outcome', 'zero', 'hold-last-value'],
        ['execute', 'zero', 'hold-last-value'],
      ],
    )
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
})

test('settings that the other gauge does not give say why, and are read again on request', async () => {
  const { page, close } = await openPage(browser, `${station.url}/gauge/pcg550%206`)
  try {
    const json = {
      type: 'about:blank',
      status: 503,
      title: 'Service Unavailable',
      detail: 'The gauge does not answer.',
    }
    let isFailing = true
    await page.route('**/api/gauges/pcg550%205/blocks', (route) =>
      isFailing ? route.fulfill({ status: 503, json }) : route.continue(),
    )
    await page.getByLabel('Compare settings with').selectOption('pcg550 5')
    const state = page.locator('.query-state.failed', { hasText: 'The gauge does not answer.' })
    await state.waitFor()
    isFailing = false
    await state.getByRole('button', { name: 'Try again' }).click()
    await page.getByRole('region', { name: 'Settings beside those of pcg550 5' }).waitFor()
    await becomes(() => state.count(), 0)
  } finally {
    await close()
  }
})

test('a gauge without another one of its model is compared with none', async () => {
  const { page, close } = await openPage(browser, `${station.url}/gauge/bcg450%207`)
  try {
    await page.locator('.parameters').first().waitFor()
    await becomes(() => page.getByLabel('Compare settings with').count(), 0)
  } finally {
    await close()
  }
})
