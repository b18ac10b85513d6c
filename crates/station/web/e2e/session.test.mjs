// Login, logout, sessions that end, and the change of a password.

import assert from 'node:assert/strict'
import { readFile, rename, writeFile } from 'node:fs/promises'
import { after, before, test } from 'node:test'
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

/** Opens a page in a browser without a session. Refused requests are the only errors that the console may show. */
async function visit(path, look, options = {}) {
  const { page, complaints, close } = await openContext(browser, options)
  try {
    await page.goto(plant.url + path)
    await look(page)
    assert.deepEqual(
      complaints.filter((complaint) => !/status of (401|403|400)/.test(complaint)),
      [],
    )
  } finally {
    await close()
  }
}

async function login(page, name, password = PASSWORD) {
  await page.getByLabel('Name').fill(name)
  await page.getByLabel('Password', { exact: true }).fill(password)
  await page.getByLabel('Password', { exact: true }).press('Enter')
}

const live = (page) => page.locator('header .connection.good').waitFor()
const loggedOut = (page) => page.getByRole('heading', { name: 'Log in' }).waitFor()

test('the station shows nothing before the login, and afterwards the page of the address', async () => {
  await visit('/events', async (page) => {
    await loggedOut(page)
    assert.equal(await page.title(), 'Log in · profivac')
    await becomes(() => page.locator('nav').count(), 0)
    assert.ok(!(await page.locator('body').innerText()).includes('Target hall'))
    await login(page, 'ada')
    await live(page)
    await becomes(() => page.locator('nav [aria-current]').innerText(), 'Events')
    assert.match(await page.locator('header .user').innerText(), /ada\s+engineer/)
    await page.locator('.events td').getByText('ada (engineer) logged in from 127.0.0.1').first().waitFor()
  })
})

test('the login works with the keyboard alone, and with a password manager', async () => {
  await visit('/', async (page) => {
    await loggedOut(page)
    assert.equal(await page.evaluate(() => document.activeElement.autocomplete), 'username')
    await page.keyboard.type('vera')
    await page.keyboard.press('Tab')
    assert.equal(await page.evaluate(() => document.activeElement.autocomplete), 'current-password')
    await page.keyboard.insertText(PASSWORD)
    await page.keyboard.press('Tab')
    await page.keyboard.press('Space')
    await becomes(() => page.getByLabel('Password', { exact: true }).getAttribute('type'), 'text')
    await page.keyboard.press('Space')
    await becomes(() => page.getByLabel('Password', { exact: true }).getAttribute('type'), 'password')
    await page.keyboard.press('Tab')
    await page.keyboard.press('Enter')
    await live(page)
    assert.match(await page.locator('header .user').innerText(), /vera\s+viewer/)
  })
})

test('the edges of the fields are seen, in light and dark', async () => {
  for (const colorScheme of ['light', 'dark']) {
    await visit(
      '/',
      async (page) => {
        await page.getByRole('button', { name: 'Log in' }).waitFor()
        // WCAG 2.2, 1.4.11.
        const contrast = await page.getByLabel('Name').evaluate((field) => {
          const light = (colour) => {
            const [red, green, blue] = colour
              .match(/[\d.]+/g)
              .map((part) => part / 255)
              .map((part) => (part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4))
            return 0.2126 * red + 0.7152 * green + 0.0722 * blue
          }
          const { borderTopColor, backgroundColor } = getComputedStyle(field)
          const [low, high] = [light(borderTopColor), light(backgroundColor)].sort((one, other) => one - other)
          return (high + 0.05) / (low + 0.05)
        })
        assert.ok(contrast >= 3, `${colorScheme}: ${contrast}`)
      },
      { colorScheme },
    )
  }
})

test('a wrong password and an unknown name are refused with the same text', async () => {
  await visit('/', async (page) => {
    const said = []
    for (const name of ['ada', 'nobody']) {
      await login(page, name, 'wrong password')
      said.push(await page.getByRole('alert').innerText())
      assert.equal(await page.evaluate(() => document.activeElement.autocomplete), 'current-password')
    }
    assert.deepEqual(said, Array(2).fill('Login failed: wrong name or password.'))
  })
})

test('a logout holds for every window', async () => {
  await visit('/', async (page) => {
    await login(page, 'olga')
    await live(page)
    const other = await page.context().newPage()
    await other.goto(`${plant.url}/bus`)
    await live(other)
    await page.getByRole('button', { name: 'Log out' }).click()
    await loggedOut(page)
    await becomes(() => page.getByText('Your session has ended').count(), 0)
    await other.getByText('Your session has ended').waitFor()
    await other.goBack().catch(() => {})
    await page.reload()
    await loggedOut(page)
  })
})

test('a window that the browser had frozen shows the user who has logged in meanwhile', async () => {
  await visit('/', async (page) => {
    const user = (window, name) => window.locator('header .user').getByText(name).first().waitFor()
    await login(page, 'olga')
    await live(page)
    await user(page, 'olga')
    await page.evaluate(() => document.dispatchEvent(new Event('freeze')))
    const other = await page.context().newPage()
    await other.goto(plant.url)
    await user(other, 'olga')
    await other.evaluate(async (password) => {
      const body = JSON.stringify({ name: 'vera', password })
      await fetch('/api/login', { method: 'POST', headers: { 'content-type': 'application/json' }, body })
    }, PASSWORD)
    await user(other, 'vera')
    await page.evaluate(() => document.dispatchEvent(new Event('resume')))
    await user(page, 'vera')
  })
})

test('after a session has ended, a new login returns to the same page', async () => {
  await visit('/gauge/chamber', async (page) => {
    await login(page, 'vera')
    await live(page)
    const again = page.getByRole('button', { name: 'Read again', disabled: false })
    await again.waitFor()
    await page.context().clearCookies()
    await again.click()
    await page.getByText('Your session has ended').waitFor()
    await becomes(() => page.getByLabel('Name').inputValue(), 'vera')
    assert.equal(await page.evaluate(() => document.activeElement.autocomplete), 'current-password')
    await page.keyboard.insertText(PASSWORD)
    await page.keyboard.press('Enter')
    await live(page)
    assert.equal(new URL(page.url()).pathname, '/gauge/chamber')
    await page.locator('h2', { hasText: 'chamber' }).waitFor()
  })
})

test('a user who is removed is logged out within two seconds', async () => {
  const file = plant.users
  const users = await readFile(file, 'utf8')
  await visit('/', async (page) => {
    await login(page, 'olga')
    await live(page)
    await writeFile(`${file}.new`, users.replace(/\[\[user\]\]\nname = "olga"[^[]*/, ''), { mode: 0o600 })
    await rename(`${file}.new`, file)
    await loggedOut(page)
    await writeFile(`${file}.new`, users, { mode: 0o600 })
    await rename(`${file}.new`, file)
  })
})

test('a user changes the password, and a weak one is refused', async () => {
  await visit('/', async (page) => {
    await login(page, 'vera')
    await live(page)
    await page.getByRole('button', { name: 'vera viewer' }).click()
    const change = async (next) => {
      await page.getByLabel('Current password', { exact: true }).fill(PASSWORD)
      await page.getByLabel('New password', { exact: true }).fill(next)
      await page.getByRole('button', { name: 'Change password' }).click()
    }
    await change('password1')
    assert.match(
      await page.getByRole('alert').innerText(),
      /^The password is not changed: this password is easily guessed/,
    )
    await change('orchid ladder seventeen')
    await page.getByText('The password is changed.').waitFor()
    await page.getByRole('button', { name: 'Close' }).click()
    await live(page)
    await page.getByRole('button', { name: 'Log out' }).click()
    await login(page, 'vera')
    await page.getByRole('alert').waitFor()
    await login(page, 'vera', 'orchid ladder seventeen')
    await live(page)
  })
})
