// Login by OpenID Connect: a station of the real program, and oidc-provider, a certified server, both on this computer. Browsers reach
// the server as localhost and the station as 127.0.0.1, so that these are two sites.

import assert from 'node:assert/strict'
import { generateKeyPairSync } from 'node:crypto'
import { mkdtemp, rm, writeFile } from 'node:fs/promises'
import { createServer } from 'node:http'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after, before, test } from 'node:test'
import Provider from 'oidc-provider'
import { violations } from './axe.mjs'
import { addUser, openContext, startArchive, startBrowser, startStation } from './setup.mjs'

const SECRET = 'a secret with spaces & signs: +%'
const PASSWORD = 'tin whisker plateau'

/** The groups of each user of the provider. */
const GROUPS = { erna: ['staff', 'vacuum-engineer'], otto: ['vacuum-operator'], gast: ['staff'] }

let browser
let folder
let station
let archive
let server

/** A new key of this type as JSON. */
function key(type, options, id) {
  const { privateKey } = generateKeyPairSync(type, options)
  return { ...privateKey.export({ format: 'jwk' }), kid: id, use: 'sig' }
}

const rsa = (id) => ({ ...key('rsa', { modulusLength: 2048 }, id), alg: 'RS256' })
const ec = (id) => ({ ...key('ec', { namedCurve: 'P-256' }, id), alg: 'ES256' })
const pss = (id) => ({ ...rsa(id), alg: 'PS256' })

/** Lets the server answer as a provider that signs with this key alone. */
function provideWith(jwk, issuer = server.issuer) {
  const provider = new Provider(issuer, {
    clients: [
      {
        client_id: 'profivac',
        client_secret: SECRET,
        redirect_uris: [station, archive].map(({ url }) => `${url}/openid`),
        post_logout_redirect_uris: [station, archive].map(({ url }) => `${url}/`),
        id_token_signed_response_alg: jwk.alg,
      },
    ],
    jwks: { keys: [jwk] },
    cookies: { keys: ['for tests'] },
    claims: { openid: ['sub'], profile: ['preferred_username', 'lab'] },
    // The claims are in the ID token.
    conformIdTokenClaims: false,
    pkce: { required: () => true },
    findAccount: (_, id) => ({
      accountId: id,
      claims: () => ({ sub: id, preferred_username: id, lab: { groups: GROUPS[id] ?? [] } }),
    }),
    features: { devInteractions: { enabled: true }, rpInitiatedLogout: { enabled: true } },
  })
  server.removeAllListeners('request')
  server.on('request', provider.callback())
}

before(async () => {
  folder = await mkdtemp(join(tmpdir(), 'profivac-openid-'))
  server = createServer()
  await new Promise((done) => server.listen(0, 'localhost', done))
  server.issuer = `http://localhost:${server.address().port}`
  const file = join(folder, 'hall.toml')
  await writeFile(join(folder, 'line.toml'), 'devices = ["bcg450@5"]\npressure = "2e-4 mbar"\n')
  await writeFile(join(folder, 'openid.secret'), `${SECRET}\n`, { mode: 0o600 })
  const openid = (table) => [
    `[${table}]\nname = "Lab login"`,
    `issuer = "${server.issuer}"\nclient-id = "profivac"\nclient-secret-file = "openid.secret"`,
    'roles-claim = "lab.groups"',
    `[${table}.roles]\noperator = ["vacuum-operator"]\nengineer = ["vacuum-engineer"]`,
  ]
  const lines = [
    ...openid('openid'),
    '[[segment]]\nname = "hall"\nport = "sim:line.toml"',
    '[[segment.gauge]]\nname = "chamber"\naddress = 5\ndevice = "bcg450"\n',
  ]
  await writeFile(file, lines.join('\n'), { mode: 0o600 })
  await addUser(file, 'ada', 'engineer', PASSWORD)
  // Logins need neither NATS nor PostgreSQL.
  const ofArchive = join(folder, 'archive.toml')
  const tables = [
    '[nats]\nservers = ["nats://127.0.0.1:1"]',
    '[postgres]\nconnection = "host=127.0.0.1 port=1 user=none dbname=none"',
    '[view]\nlisten = "127.0.0.1:0"\nusers = "archive.users"',
    ...openid('view.openid'),
    '[[plant]]\nname = "hall"\nreaders = []\nusers = ["openid:otto"]\n',
  ]
  await writeFile(ofArchive, tables.join('\n'), { mode: 0o600 })
  await addUser(ofArchive, 'eve', 'viewer', PASSWORD)
  ;[browser, station, archive] = await Promise.all([startBrowser(), startStation(file), startArchive(ofArchive)])
  provideWith(rsa('first'))
})

after(async () => {
  await browser?.close()
  await Promise.all([station?.stop(), archive?.stop()])
  server?.closeAllConnections()
  await new Promise((done) => (server ? server.close(done) : done()))
  await rm(folder, { recursive: true, force: true })
})

const button = (page) => page.getByRole('button', { name: 'Log in with Lab login' })
const live = (page) => page.locator('header .connection.good').waitFor()
const loggedOut = (page) => page.getByRole('heading', { name: 'Log in' }).waitFor()

/** Opens a page of the station in a new browser. Refused requests are the only errors that the console may show. */
async function visit(path, look, { at = station, ...options } = {}) {
  const { page, complaints, close } = await openContext(browser, options)
  try {
    // The pages of the provider ask another computer for a font.
    await page.route('https://fonts.googleapis.com/**', (route) => route.fulfill({ contentType: 'text/css', body: '' }))
    await page.goto(at.url + path)
    await look(page)
    assert.deepEqual(
      complaints.filter((complaint) => !/status of (401|403|503)/.test(complaint)),
      [],
    )
  } finally {
    await close()
  }
}

/** Logs in on the pages of the provider. */
async function atProvider(page, name) {
  await page.locator('input[name=login]').fill(name)
  await page.locator('input[name=password]').fill('any')
  await page.getByRole('button', { name: 'Sign-in' }).click()
  await page.getByRole('button', { name: 'Continue' }).click()
}

async function login(page, name) {
  await button(page).click()
  await atProvider(page, name)
}

test('a user of the provider logs in, acts under the own name, and logs out at both', async () => {
  await visit('/audit', async (page) => {
    await loggedOut(page)
    assert.deepEqual(await violations(page), [])
    await login(page, 'otto')
    await live(page)
    const address = new URL(page.url())
    assert.deepEqual([address.pathname, address.search], ['/audit', ''], 'the page of before, without state and code')
    assert.match(await page.locator('header .user').innerText(), /openid:otto\s+operator/)
    assert.equal(await page.getByRole('button', { name: /openid:otto/ }).count(), 0, 'no password to change here')
    await page.locator('.control').getByRole('button', { name: 'Request control' }).click()
    await page.locator('.control').getByText('You have control').waitFor()
    await page.goto(`${station.url}/audit`)
    await page.locator('td').getByText('openid:otto').first().waitFor()
    await page.goto(`${station.url}/events`)
    await page.locator('td').getByText('openid:otto (operator) logged in from 127.0.0.1').first().waitFor()
    await page.getByRole('button', { name: 'Log out' }).click()
    await page.getByRole('button', { name: 'Yes, sign me out' }).click()
    await loggedOut(page)
    assert.equal(new URL(page.url()).origin, station.url)
    await button(page).click()
    await page.locator('input[name=login]').waitFor()
  })
})

test('the login is in German too', async () => {
  const german = { locale: 'de-DE' }
  await visit(
    '/',
    async (page) => {
      await page.getByText('Oder mit Name und Passwort dieser Station:').waitFor()
      await page.getByRole('button', { name: 'Anmelden mit Lab login' }).click()
      await atProvider(page, 'erna')
      await page.locator('header .connection.good').waitFor()
      assert.match(await page.locator('header .user').innerText(), /openid:erna\s+Ingenieur/)
    },
    german,
  )
})

test('a user without a role is refused with the name of the claim, and the users of the file log in beside', async () => {
  await visit('/trends', async (page) => {
    await login(page, 'gast')
    const said = await page.getByRole('alert').innerText()
    assert.equal(
      said,
      'Login failed: openid:gast has no role at this station: expected in the claim lab.groups a value that the ' +
        "station's file maps to a role, found others only.",
    )
    assert.deepEqual(await violations(page), [])
    await page.getByLabel('Name').fill('ada')
    await page.getByLabel('Password', { exact: true }).fill(PASSWORD)
    await page.getByLabel('Password', { exact: true }).press('Enter')
    await live(page)
    assert.match(await page.locator('header .user').innerText(), /ada\s+engineer/)
    assert.equal(new URL(page.url()).pathname, '/trends')
  })
})

test('a login that the user cancels is refused with a sentence', async () => {
  await visit('/', async (page) => {
    await button(page).click()
    await page.locator('input[name=login]').waitFor()
    await page.getByRole('link', { name: 'Cancel' }).click()
    assert.equal(
      await page.getByRole('alert').innerText(),
      'Login failed: Lab login has refused the login: access_denied.',
    )
  })
})

test('the address of a completed login begins no session in another browser', async () => {
  let returned
  await visit('/', async (page) => {
    // The browser of the attacker keeps the answer of the provider for another one.
    await page.route('**/api/openid/login', (route) => {
      returned = route.request().postDataJSON()
      return route.fulfill({ status: 503, json: { detail: 'stopped' } })
    })
    await login(page, 'erna')
    await page.getByText('Login failed: stopped.').waitFor()
  })
  const { state, code, iss } = returned
  await visit(`/openid?${new URLSearchParams({ state, code, iss })}`, async (page) => {
    await loggedOut(page)
    assert.match(
      await page.getByRole('alert').innerText(),
      /^Login failed: this login began .* in another browser; log in again\.$/,
    )
    assert.equal(new URL(page.url()).pathname, '/')
  })
})

test('the provider changes its key, and logins go on', async () => {
  for (const jwk of [ec('second'), pss('third')]) {
    provideWith(jwk)
    await visit('/', async (page) => {
      await login(page, 'erna')
      await live(page)
      assert.match(await page.locator('header .user').innerText(), /openid:erna\s+engineer/)
    })
  }
})

test('a provider that is down gives a sentence, and passwords work', async () => {
  server.removeAllListeners('request')
  server.on('request', (_, answer) => answer.writeHead(500).end())
  try {
    await visit('/', async (page) => {
      // The description of the provider is known for an hour: the failure shows when the code is exchanged.
      await page.route(`${server.issuer}/**`, (route) => {
        const to = new URL(route.request().url()).searchParams
        const back = `${to.get('redirect_uri')}?state=${to.get('state')}&code=any&iss=${encodeURIComponent(server.issuer)}`
        return route.fulfill({ status: 303, headers: { location: back } })
      })
      await button(page).click()
      assert.equal(
        await page.getByRole('alert').innerText(),
        'Login failed: Lab login cannot be asked: expected an answer with status 200 from localhost, found 500; ' +
          'try again, or log in with a name and a password of this station.',
      )
      await page.getByLabel('Name').fill('ada')
      await page.getByLabel('Password', { exact: true }).fill(PASSWORD)
      await page.getByLabel('Password', { exact: true }).press('Enter')
      await live(page)
    })
  } finally {
    provideWith(rsa('fourth'))
  }
})

test('a user of the provider logs in at the page of an archive, with the role there, and logs out at both', async () => {
  await visit(
    '/alarms',
    async (page) => {
      await loggedOut(page)
      await login(page, 'otto')
      await live(page)
      const address = new URL(page.url())
      assert.deepEqual([address.origin, address.pathname, address.search], [archive.url, '/alarms', ''])
      assert.match(await page.locator('header .user').innerText(), /openid:otto\s+operator/)
      const { name, role } = await page.evaluate(async () => (await fetch('/api/session')).json())
      assert.deepEqual([name, role], ['openid:otto', 'operator'])
      await page.getByRole('button', { name: 'Log out' }).click()
      await page.getByRole('button', { name: 'Yes, sign me out' }).click()
      await loggedOut(page)
      assert.equal(new URL(page.url()).origin, archive.url)
      const status = await page.evaluate(async () => (await fetch('/api/archive')).status)
      assert.equal(status, 401)
    },
    { at: archive },
  )
})

test('an archive refuses a user of the provider without a role', async () => {
  await visit(
    '/',
    async (page) => {
      await login(page, 'gast')
      assert.match(await page.getByRole('alert').innerText(), /^Login failed: openid:gast has no role/)
      await loggedOut(page)
    },
    { at: archive },
  )
})
