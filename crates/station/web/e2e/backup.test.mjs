// The copy of the database in a browser: an engineer downloads it, and the program opens it.

import assert from 'node:assert/strict'
import { after, before, test } from 'node:test'
import { violations } from './axe.mjs'
import { becomes, openContext, openPage, runProgram, startBrowser, startLastingDemo, startPlant } from './setup.mjs'

let browser
let demo
let plant

before(async () => {
  ;[browser, demo, plant] = await Promise.all([startBrowser(), startLastingDemo(), startPlant('127.0.0.1:0', 'users')])
})

after(async () => {
  await browser?.close()
  await demo?.stop()
  await plant?.stop()
})

/** Makes a copy in the dialog, and downloads it. Returns the name and the path of the file. */
async function copy(page, words) {
  await page.getByRole('button', { name: words.open }).click()
  const dialog = page.getByRole('dialog', { name: words.title })
  await dialog.getByRole('button', { name: words.make }).click()
  const link = dialog.getByRole('link', { name: words.save })
  await link.waitFor()
  assert.match(await dialog.getByRole('status').innerText(), words.made)
  assert.deepEqual(await violations(page), [])
  const [download] = await Promise.all([page.waitForEvent('download'), link.click()])
  return { name: download.suggestedFilename(), path: await download.path() }
}

const ENGLISH = {
  open: 'Copy the database',
  title: 'Copy of the database',
  make: 'Make the copy',
  save: 'Download the copy',
  made: /^The copy of \d{4}-\d\d-\d\d [\d:]{8} has [\d.]+\s[kM]B\. It can be downloaded until [\d:]{8}/,
}

const GERMAN = {
  open: 'Datenbank kopieren',
  title: 'Kopie der Datenbank',
  make: 'Kopie erstellen',
  save: 'Kopie herunterladen',
  made: /^Die Kopie von .* kann bis [\d:]{8} heruntergeladen werden/,
}

test('an engineer downloads a copy of the database, the program opens it, and the audit trail has the copy', async () => {
  const { page, complaints, close } = await openPage(browser, `${demo.url}/audit`)
  try {
    const { name, path } = await copy(page, ENGLISH)
    assert.match(name, /^backup-\d{4}-\d\d-\d\d-\d{6}\.db$/)
    const csv = await runProgram('export', path)
    assert.ok(csv.split('\n').length > 12, csv.slice(0, 500))
    assert.match(csv, /bcg450 5/)
    await page.keyboard.press('Escape')
    const row = page.locator('.audit [data-kind="backup"]')
    await row.waitFor()
    await page.locator('.audit [data-kind="outcome"]', { hasText: /done: \d+ octets/ }).waitFor()
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
})

test('the copy is made in German, on a phone too', async () => {
  const options = { locale: 'de-DE', viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true }
  const { page, complaints, close } = await openPage(browser, `${demo.url}/audit`, options)
  try {
    await copy(page, GERMAN)
    const needed = await page.evaluate(() => document.documentElement.scrollWidth)
    assert.ok(needed <= 360, `the page needs ${needed} pixels`)
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
})

test('an operator has no button for a copy, and the station refuses it', async () => {
  const { page, close } = await openContext(browser)
  try {
    await page.goto(`${plant.url}/audit`)
    await page.getByLabel('Name').fill('olga')
    await page.getByLabel('Password', { exact: true }).fill('tin whisker plateau')
    await page.getByLabel('Password', { exact: true }).press('Enter')
    await page.getByRole('link', { name: 'Save as CSV' }).waitFor()
    await becomes(() => page.getByRole('button', { name: ENGLISH.open }).count(), 0)
    const status = await page.evaluate(async () => {
      const { token } = await (await fetch('/api/session')).json()
      return (await fetch('/api/backup', { method: 'POST', headers: { 'x-csrf-token': token } })).status
    })
    assert.equal(status, 403)
  } finally {
    await close()
  }
})
