// The pages in German: the language of the browser or the chosen one, no English text left, and the rules of WCAG as in English.

import assert from 'node:assert/strict'
import { after, before, test } from 'node:test'
import { violations } from './axe.mjs'
import { check } from './german.mjs'
import { drawn, openContext, openPage, startActing, startBrowser, startLastingDemo, startPlant } from './setup.mjs'

const GERMAN = { locale: 'de-DE' }
const PHONE = { viewport: { width: 320, height: 640 }, isMobile: true, hasTouch: true }

let browser
let plant
let large
let guarded
let acting
let demo
let pumped

before(async () => {
  ;[browser, plant, large, guarded, acting, demo, pumped] = await Promise.all([
    startBrowser(),
    startPlant('127.0.0.1:0', 'hostile'),
    startPlant('127.0.0.1:0', 'large'),
    startPlant('127.0.0.1:0', 'users'),
    startActing(),
    startLastingDemo(),
    startPlant('127.0.0.1:0', 'pumped'),
  ])
})

after(async () => {
  await browser?.close()
  await Promise.all([plant, large, guarded, acting, demo, pumped].map((one) => one?.stop()))
})

const table = (page) => page.locator('main tbody tr').first().waitFor()

/** The pages with their headings, and what is there when they are complete. */
const PAGES = {
  '/': ['Übersicht', (page) => page.locator('main .card').first().waitFor()],
  '/plant': ['Anlage', (page) => page.locator('main .waiting').waitFor()],
  '/trends?range=1h&s=chamber&s=gate+1': ['Verlauf', drawn],
  '/trends/pump-downs': ['Abpumpvorgänge', (page) => page.locator('.pump-downs .muted, .runs').first().waitFor()],
  '/bus': ['Busübersicht', (page) => page.getByRole('button', { name: /^9: / }).click()],
  '/gauge/chamber': ['Messgerät', (page) => page.locator('.parameters').first().waitFor()],
  '/rise?s=vessel': ['Druckanstieg', drawn],
  '/rise/identify?series=vessel': ['Anlage aus ihrer Aufzeichnung', (page) => page.locator('main .panel').waitFor()],
  '/events': ['Ereignisse', table],
  '/alarms': ['Alarme', (page) => page.locator('.alarm-item').first().waitFor()],
  '/audit': ['Audit-Trail', (page) => page.locator('main .audit').waitFor()],
  '/gateways': ['Gateways', (page) => page.locator('main .gateways').waitFor()],
  '/nowhere': [null, (page) => page.getByRole('link', { name: 'Zur Übersicht' }).waitFor()],
}

test('a German browser shows every page in German', async () => {
  for (const [path, [heading, ready]] of Object.entries(PAGES)) {
    const { page, complaints, close } = await openPage(browser, plant.url + path, GERMAN)
    try {
      await ready(page)
      if (heading) assert.equal(await page.locator('main h1').textContent(), heading)
      for (const summary of await page.locator('main summary').all()) await summary.click()
      await check(page, path)
      // The made-up station has no line, and so no statistics of one.
      const others = complaints.filter((complaint) => path !== '/bus' || !complaint.includes('404'))
      assert.deepEqual(others, [], path)
    } finally {
      await close()
    }
  }
})

test('a rise, the pump-downs and an identified plant have their results in German', async () => {
  const { started_ms: end } = await plant.json('/api/station')
  const rise = `${plant.url}/rise?s=vessel&begin=${end - 600_000}&end=${end}&litres=12`
  const { page, close } = await openPage(browser, rise, GERMAN)
  try {
    await page.locator('.result dt', { hasText: 'Leck' }).waitFor()
    await check(page, 'rise')
    await page.goto(`${pumped.url}/trends/pump-downs?series=transfer%20lock`)
    await page.locator('svg polyline.shown').waitFor()
    await check(page, 'pump-downs')
    await page.goto(`${pumped.url}/rise/identify?series=test%20chamber`)
    await page.getByRole('spinbutton', { name: 'Volumen L' }).fill('50')
    await page.getByRole('button', { name: 'Bestimmen' }).click()
    await page.getByRole('heading', { name: 'Was am meisten hilft' }).waitFor()
    await page.getByText('das Leck schließen').waitFor()
    await check(page, 'identify')
  } finally {
    await close()
  }
})

test('480 gauges and the wall display are German', async () => {
  const { page, close } = await openPage(browser, `${large.url}/?state=problems`, GERMAN)
  try {
    await page.locator('main .row').first().waitFor()
    await page.getByText(/^\d+ von 480 Messgeräten$/).waitFor()
    await check(page, 'rows')
    await page.goto(`${large.url}/wall`)
    await page.getByText(/^Seite \d+ von \d+$/).waitFor()
    await check(page, 'wall')
  } finally {
    await close()
  }
})

test('the picture of the plant is German', async () => {
  const { page, close } = await openPage(browser, `${demo.url}/plant`, GERMAN)
  try {
    await page.locator('main svg').first().waitFor()
    await page.getByRole('columnheader', { name: 'Bauteil' }).waitFor()
    await page.locator('main details').evaluateAll((all) => {
      for (const one of all) one.open = true
    })
    // The name of a volume says in a sentence what the picture shows in lines.
    await check(page, 'plant', ['label-content-name-mismatch'])
  } finally {
    await close()
  }
})

async function login(page, name) {
  await page.getByLabel('Name').fill(name)
  await page.getByLabel('Passwort', { exact: true }).fill('tin whisker plateau')
  await page.getByLabel('Passwort', { exact: true }).press('Enter')
  await page.locator('header .connection.good').waitFor()
}

/** Opens a page as the engineer, in German. */
async function asEngineer(path, look) {
  const { page, close } = await openContext(browser, GERMAN)
  try {
    await page.goto(guarded.url + path)
    await page.getByRole('heading', { name: 'Anmelden' }).waitFor()
    await check(page, 'login')
    await login(page, 'ada')
    await look(page)
  } finally {
    await close()
  }
}

test('the login, the help and the dialogs of alarms are German', async () => {
  await asEngineer('/alarms', async (page) => {
    await page.getByRole('button', { name: 'Hilfe' }).click()
    await page.getByRole('dialog', { name: 'Hilfe' }).waitFor()
    await check(page, 'help')
    await page.keyboard.press('Escape')
    const all = page.getByRole('region', { name: 'Alle Alarme' })
    await all.locator('summary').click()
    await all.getByRole('searchbox').fill('vessel vented')
    await all.getByRole('button', { name: 'Einstellungen: vessel vented' }).click()
    await page.getByRole('dialog').getByLabel('Ansprechverzögerung').waitFor()
    await check(page, 'settings')
    await page.getByRole('button', { name: 'Abbrechen' }).click()
    await all.getByRole('button', { name: 'Zurückstellen: vessel vented' }).click()
    await page.getByRole('dialog', { name: 'Zurückstellen' }).getByLabel('Grund').fill('Wartung')
    await check(page, 'shelve')
    await page.getByRole('dialog').getByRole('button', { name: 'Zurückstellen' }).click()
    await page.getByRole('region', { name: 'Zurückgestellt' }).getByText('Wartung').waitFor()
    await page.getByRole('button', { name: 'Zurückstellung beenden' }).click()
    await page.locator('header button.user').click()
    await page.getByRole('dialog', { name: 'Passwort von ada ändern' }).waitFor()
    await check(page, 'password')
  })
})

test('a command is armed and sent in German, with the words of the manual', async () => {
  const { page, close } = await openContext(browser, GERMAN)
  try {
    await page.goto(`${acting.url}/gauge/chamber`)
    await login(page, 'Otto')
    await page.locator('.control').getByRole('button', { name: 'Anfordern' }).click()
    await page.locator('.control').getByText('Bedienhoheit bei Ihnen').waitFor()
    const commands = page.getByRole('region', { name: 'Befehle' })
    await check(page, 'commands')
    await commands.getByText('heizt die Elektroden drei Minuten lang: Gas wird frei, und der Druck steigt').waitFor()
    await commands.getByRole('button', { name: 'Entgasen beenden' }).click()
    const dialog = page.getByRole('dialog', { name: 'Befehl' })
    await dialog.getByRole('button', { name: 'Senden' }).waitFor()
    await dialog.getByText(/noch \d+ s scharf/).waitFor()
    await check(page, 'armed')
    await dialog.getByRole('button', { name: 'Senden' }).click()
    await dialog.getByText(/^Ausgeführt: ba\.degas-off/).waitFor()
    await check(page, 'sent')
    await dialog.getByRole('button', { name: 'Schließen' }).click()
    await page.goto(`${acting.url}/audit`)
    await page.getByRole('row').filter({ hasText: 'gesendet' }).first().waitFor()
    await check(page, 'audit')
    await page.setViewportSize({ width: 360, height: 740 })
    const empty = page.locator('.log td:last-child:empty')
    for (const cell of await empty.all()) assert.ok(await cell.isHidden(), 'the name of an empty column')
    assert.equal(await page.locator('.log thead th').last().textContent(), 'Ergebnis oder Grund')
  } finally {
    await close()
  }
})

test('the language is chosen in the header and remembered, and English needs no file of another language', async () => {
  const { page, complaints, close } = await openPage(browser, plant.url)
  try {
    const lang = () => page.evaluate(() => document.documentElement.lang)
    const files = () => page.evaluate(() => performance.getEntriesByType('resource').map(({ name }) => name))
    assert.equal(await lang(), 'en')
    assert.equal((await files()).filter((name) => /\/de-[^/]*\.js$/.test(name)).length, 0)
    await page.getByRole('button', { name: 'Deutsch' }).click()
    await page.getByRole('link', { name: 'Druckanstieg' }).waitFor()
    assert.equal(await lang(), 'de')
    await page.waitForFunction(() => document.title.includes('Übersicht · '))
    assert.equal((await files()).filter((name) => /\/de-[^/]*\.js$/.test(name)).length, 1)
    await page.reload()
    await page.getByRole('link', { name: 'Druckanstieg' }).waitFor()
    await page.getByRole('button', { name: 'English' }).click()
    await page.getByRole('link', { name: 'Rate of rise' }).waitFor()
    assert.equal(await lang(), 'en')
    await page.goto(`${plant.url}/wall`)
    await page.locator('.wall-tile').first().waitFor()
    assert.equal(await lang(), 'en')
    assert.deepEqual(complaints, [])
  } finally {
    await close()
  }
})

test('without the German texts the pages stay as they are', async () => {
  const { page, close } = await openContext(browser, GERMAN)
  try {
    await page.route(/\/de-[^/]*\.js$/, (route) => route.abort())
    await page.goto(plant.url)
    await page.getByRole('link', { name: 'Rate of rise' }).waitFor()
    assert.equal(await page.evaluate(() => document.documentElement.lang), 'en')
  } finally {
    await close()
  }
})

test('a phone shows all pages in German without scrolling sideways', async () => {
  for (const [path, [, ready]] of Object.entries(PAGES)) {
    const { page, close } = await openPage(browser, plant.url + path, { ...GERMAN, ...PHONE })
    try {
      await ready(page)
      const header = await page.locator('header').evaluate(({ offsetHeight }) => offsetHeight)
      assert.ok(header <= 200, `${path}: a header of ${header} pixels`)
      const [needed, width] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth])
      assert.ok(needed <= 320 && width === 320, `${path} needs ${needed} of ${width} pixels`)
      assert.deepEqual(await violations(page), [], path)
    } finally {
      await close()
    }
  }
})
