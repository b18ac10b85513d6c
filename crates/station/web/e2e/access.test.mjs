// The rules of WCAG 2.2 AA that axe can check, on every page in light and dark, and on every dialog.

import assert from 'node:assert/strict'
import { after, before, test } from 'node:test'
import { violations } from './axe.mjs'
import { drawn, openContext, openPage, startBrowser, startLastingDemo, startPlant } from './setup.mjs'

let browser
let plant
let guarded
let demo

before(async () => {
  ;[browser, plant, guarded, demo] = await Promise.all([
    startBrowser(),
    startPlant('127.0.0.1:0', 'hostile'),
    startPlant('127.0.0.1:0', 'users'),
    startLastingDemo(),
  ])
})

after(async () => {
  await browser?.close()
  await plant?.stop()
  await guarded?.stop()
  await demo?.stop()
})

const heading = (page) => page.locator('main h1').waitFor()

const card = (page) => page.locator('main :is(.card, .panel)').first().waitFor()

const PAGES = {
  '/': card,
  '/plant': heading,
  '/trends?range=1h&s=chamber&s=gate+1': drawn,
  '/bus': (page) => page.getByRole('button', { name: /^9: / }).click(),
  '/gauge': heading,
  '/gauge/chamber': (page) => page.locator('.parameters').first().waitFor(),
  '/rise?s=vessel': drawn,
  '/rise/identify?series=vessel': card,
  '/events': (page) => page.locator('.events tbody tr').first().waitFor(),
  '/alarms': (page) => page.locator('.alarm-item').first().waitFor(),
  '/audit': heading,
  '/gateways': heading,
}

const PHONE = { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true }

const LOOKS = {
  light: { colorScheme: 'light' },
  dark: { colorScheme: 'dark' },
  'light on a phone': { colorScheme: 'light', ...PHONE },
  'dark on a phone': { colorScheme: 'dark', ...PHONE },
}

for (const [name, options] of Object.entries(LOOKS)) {
  test(`axe finds nothing on any page, ${name}`, async () => {
    for (const [path, ready] of Object.entries(PAGES)) {
      const { page, close } = await openPage(browser, plant.url + path, options)
      try {
        await ready(page)
        assert.deepEqual(await violations(page), [], path)
      } finally {
        await close()
      }
    }
  })
}

/** Logs an engineer in, and shows a page in each of the looks. */
async function asEngineer(path, look) {
  for (const [name, options] of Object.entries(LOOKS)) {
    const { page, close } = await openContext(browser, options)
    try {
      await page.goto(guarded.url + path)
      await page.getByRole('heading', { name: 'Log in' }).waitFor()
      assert.deepEqual(await violations(page), [], `login, ${name}`)
      await page.getByLabel('Name').fill('ada')
      await page.getByLabel('Password', { exact: true }).fill('tin whisker plateau')
      await page.getByLabel('Password', { exact: true }).press('Enter')
      await page.locator('header .connection.good').waitFor()
      await look(page)
      assert.deepEqual(await violations(page), [], `${path}, ${name}`)
    } finally {
      await close()
    }
  }
}

test('axe finds nothing on the login and in the settings of an alarm', async () => {
  await asEngineer('/alarms', async (page) => {
    const all = page.getByRole('region', { name: 'All alarms' })
    await all.locator('summary').click()
    await all.getByRole('searchbox').fill('vessel vented')
    await all.getByRole('button', { name: 'Settings: vessel vented' }).click()
    await page.getByRole('dialog', { name: 'Alarm settings' }).waitFor()
  })
})

test('axe finds nothing when alarms are shelved', async () => {
  await asEngineer('/alarms', async (page) => {
    await page
      .getByRole('region', { name: 'Active alarms' })
      .getByRole('button', { name: /^Shelve all/ })
      .click()
    await page.getByRole('dialog').waitFor()
  })
})

test('axe finds nothing in the help', async () => {
  await asEngineer('/events', async (page) => {
    // On a phone the menu has it.
    const menu = page.locator('header .menu')
    if (await menu.isVisible()) await menu.click()
    await page.getByRole('button', { name: 'Help' }).click()
    await page.getByRole('dialog').waitFor()
  })
})

test('axe finds nothing on the picture of the plant', async () => {
  for (const [name, options] of Object.entries(LOOKS)) {
    const { page, close } = await openPage(browser, `${demo.url}/plant`, options)
    try {
      await page.locator('main svg').first().waitFor()
      // The name of a volume says in a sentence what the picture shows in lines.
      assert.deepEqual(await violations(page, ['label-content-name-mismatch']), [], name)
    } finally {
      await close()
    }
  }
})

test('axe finds nothing on the wall display', async () => {
  const { page, close } = await openContext(browser, { viewport: { width: 1920, height: 1080 } })
  try {
    await page.goto(`${plant.url}/wall`)
    await page.locator('.wall-tile').first().waitFor()
    assert.deepEqual(await violations(page), [])
  } finally {
    await close()
  }
})
