// The page of the gateways in a browser: a station with Prometheus; `cargo build -p profivac-cli` makes the program.

import assert from 'node:assert/strict'
import { mkdtemp, rm, writeFile } from 'node:fs/promises'
import { createServer } from 'node:net'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { after, before, test } from 'node:test'
import { openPage, startBrowser, startStation } from './setup.mjs'

let browser
let folder

/** A station with one virtual gauge and this Prometheus address. */
async function startWith(listen) {
  const lines = [
    '[[segment]]\nname = "hall"',
    `port = "sim:${join(folder, 'hall.toml')}"`,
    '[[segment.gauge]]\nname = "chamber"\naddress = 5\ndevice = "bcg450"\n',
    `[prometheus]\nlisten = "${listen}"\n`,
  ]
  await writeFile(join(folder, 'plant.toml'), lines.join('\n'), { mode: 0o600 })
  return startStation(join(folder, 'plant.toml'))
}

before(async () => {
  folder = await mkdtemp(join(tmpdir(), 'profivac-gateways-'))
  await writeFile(join(folder, 'hall.toml'), 'devices = ["bcg450@5"]\n')
  browser = await startBrowser()
})

after(async () => {
  await browser?.close()
  await rm(folder, { recursive: true, force: true })
})

/** Opens the page of the gateways. The console may show no error. */
async function look(station, see) {
  const { page, complaints, close } = await openPage(browser, `${station.url}/gateways`)
  try {
    await see(page)
    assert.deepEqual(complaints, [])
  } finally {
    await close()
    await station.stop()
  }
}

test('a gateway that runs has its address and counts', async () => {
  await look(await startWith('127.0.0.1:0'), async (page) => {
    const row = page.locator('.gateways tbody tr[data-kind="running"]')
    await row.waitFor()
    const cells = await row.locator('td').allInnerTexts()
    assert.deepEqual(cells.slice(0, 2), ['Prometheus', 'running'])
    assert.match(cells[2], /^127\.0\.0\.1:\d+$/)
    assert.deepEqual(cells.slice(3), ['0', '0', '0', '0', ''])
  })
})

test('a gateway whose port is taken says so', async () => {
  const other = createServer()
  await new Promise((done) => other.listen(0, '127.0.0.1', done))
  try {
    const { port } = other.address()
    await look(await startWith(`127.0.0.1:${port}`), async (page) => {
      const row = page.locator('.gateways tbody tr', { hasText: `cannot listen on 127.0.0.1:${port}` })
      await row.waitFor()
      assert.match(await row.innerText(), /does not run, tries again/)
    })
  } finally {
    other.close()
  }
})
