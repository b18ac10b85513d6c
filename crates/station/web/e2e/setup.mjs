// What the tests in a browser share: stations with made-up data, and the Chromium of the system.

import assert from 'node:assert/strict'
import { spawn } from 'node:child_process'
import { once } from 'node:events'
import { existsSync } from 'node:fs'
import { createInterface } from 'node:readline'
import { fileURLToPath } from 'node:url'
import { isDeepStrictEqual } from 'node:util'
import { chromium } from 'playwright-core'

/** The one without windows takes a third less processor time. */
const BROWSERS = [
  '/usr/bin/chromium-headless-shell',
  '/usr/bin/chromium',
  '/usr/bin/chromium-browser',
  '/usr/bin/google-chrome',
]
const ROOT = fileURLToPath(new URL('../../../..', import.meta.url))

const EXAMPLES = `${process.env.CARGO_TARGET_DIR ?? `${ROOT}/target`}/debug/examples`

/** The program; `cargo build -p profivac-cli` makes it. */
const PROFIVAC = `${process.env.CARGO_TARGET_DIR ?? `${ROOT}/target`}/debug/profivac`

/** A station with made-up data; `cargo build -p profivac-station --example fake_plant` makes it. */
const PLANT = process.env.FAKE_PLANT ?? `${EXAMPLES}/fake_plant`

/** A station with a gauge in memory that takes commands; `cargo build -p profivac-station --example acting_plant` makes it. */
const ACTING = process.env.ACTING_PLANT ?? `${EXAMPLES}/acting_plant`

export const startPlant = (address = '127.0.0.1:0', ...more) => startProgram(PLANT, address, ...more)
export const startActing = () => startProgram(ACTING, '127.0.0.1:0')

async function startProgram(program, address, ...more) {
  const child = spawn(program, [address, ...more], { stdio: ['pipe', 'pipe', 'inherit'] })
  const lines = createInterface({ input: child.stdout })
  const failed = once(child, 'error').then(([error]) => Promise.reject(error))
  const ended = once(child, 'exit').then(([code]) => Promise.reject(new Error(`${program} ended with ${code}`)))
  ended.catch(() => {})
  failed.catch(() => {})
  // The second line is the path of the users file.
  const said = []
  const both = new Promise((done) => lines.on('line', (line) => said.push(line) === 2 && done()))
  await Promise.race([both, failed, ended])
  const [url, users] = said
  return {
    url,
    users,
    address: url.replace('http://', ''),
    json: async (path) => (await fetch(url + path)).json(),
    /** Sends a line to the program; its source lists the commands. */
    tell: (line) => child.stdin.write(`${line}\n`),
    stop: async () => {
      if (child.exitCode !== null || child.signalCode !== null) return
      const gone = once(child, 'exit')
      child.kill('SIGKILL')
      await gone
    },
  }
}

/** The demo plant with its dashboard, until it is stopped; `cargo build -p profivac-cli` makes it. */
export const startDemo = (...more) => startProfivac('demo', '--headless', ...more)

/** The same without --headless: it goes on after the end of its scenario. */
export const startLastingDemo = (...more) => startProfivac('demo', ...more)

/** Adds a user to the station with this file. */
export async function addUser(file, name, role, password) {
  const child = spawn(PROFIVAC, ['user', 'add', name, '--role', role, file, '--password-stdin'], {
    stdio: ['pipe', 'ignore', 'inherit'],
  })
  child.stdin.end(`${password}\n`)
  const [code] = await once(child, 'exit')
  if (code !== 0) throw new Error(`user add ended with ${code}`)
}

/** What a command of the program prints. */
export async function runProgram(...more) {
  const child = spawn(PROFIVAC, more, { stdio: ['ignore', 'pipe', 'inherit'] })
  let printed = ''
  child.stdout.on('data', (text) => {
    printed += text
  })
  const [code] = await once(child, 'close')
  if (code !== 0) throw new Error(`${more.join(' ')} ended with ${code}`)
  return printed
}

/** Virtual gauges behind a TCP port; a line to them, such as `pressure 1e-3 mbar`, changes them. */
export async function startGauges(...words) {
  const child = spawn(PROFIVAC, ['simulate', '--tcp', '127.0.0.1:0', ...words], { stdio: ['pipe', 'pipe', 'inherit'] })
  const [said] = await once(createInterface({ input: child.stdout }), 'line')
  return {
    port: `tcp://${said.replace('ready ', '')}`,
    tell: (line) => child.stdin.write(`${line}\n`),
    stop: async () => {
      const gone = once(child, 'exit')
      child.kill('SIGTERM')
      await gone
    },
  }
}

/** A station with this file. */
export const startStation = (file) => startProfivac('run', file)

/** An archive with this file, which needs the feature `archive`; its file says where the page is. */
export const startArchive = (file) => startWith(['archive', file])

const startProfivac = (command, ...more) => startWith([command, '--listen', '127.0.0.1:0', ...more])

async function startWith(words) {
  const program = PROFIVAC
  const child = spawn(program, words, {
    stdio: ['pipe', 'pipe', 'pipe'],
  })
  const outputs = [child.stdout, child.stderr].map((input) => createInterface({ input }))
  const failed = once(child, 'error').then(([error]) => Promise.reject(error))
  const ended = once(child, 'exit').then(([code]) => Promise.reject(new Error(`${program} ended with ${code}`)))
  ended.catch(() => {})
  failed.catch(() => {})
  // `run` says its address on its output, `demo` on its errors.
  const ready = new Promise((done) => {
    for (const lines of outputs) lines.on('line', (line) => line.includes('http://') && done(line))
  })
  const said = await Promise.race([ready, failed, ended])
  const url = said.slice(said.indexOf('http://'))
  return {
    url,
    json: async (path) => (await fetch(url + path)).json(),
    stop: async () => {
      if (child.exitCode !== null || child.signalCode !== null) return
      const gone = once(child, 'exit')
      child.kill('SIGTERM')
      await gone
    },
  }
}

export function startBrowser(more = {}) {
  const executablePath = BROWSERS.find((path) => existsSync(path))
  if (!executablePath) throw new Error(`expected a browser at one of ${BROWSERS.join(', ')}`)
  // The sandbox of Chromium does not start for root.
  const args = process.getuid?.() === 0 ? ['--no-sandbox'] : []
  return chromium.launch({ executablePath, args, env: { ...process.env, LANGUAGE: 'en_GB' }, ...more })
}

/** An empty page that collects its complaints: script errors, errors on the console, dialogs. */
export async function openContext(browser, options = {}) {
  const context = await browser.newContext({
    viewport: { width: 1280, height: 800 },
    reducedMotion: 'reduce',
    locale: 'en-GB',
    ...options,
  })
  context.setDefaultTimeout(60_000)
  const page = await context.newPage()
  // A loaded computer answers late. With this delay a test that does not wait for an answer fails every time.
  if (process.env.ANSWER_DELAY_MS) {
    await context.route('**/api/**', async (route) => {
      await new Promise((done) => setTimeout(done, Number(process.env.ANSWER_DELAY_MS)))
      await route.continue().catch(() => {})
    })
  }
  const complaints = []
  page.on('pageerror', (error) => complaints.push(String(error)))
  page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()))
  page.on('dialog', (dialog) => {
    complaints.push(`dialog: ${dialog.message()}`)
    void dialog.dismiss()
  })
  return { page, complaints, close: () => context.close() }
}

/** Opens a page of the station, and waits until it is live. */
export async function openPage(browser, url, options = {}) {
  const opened = await openContext(browser, options)
  await opened.page.goto(url)
  await opened.page.locator('header .connection.good').waitFor()
  assert.equal(await opened.page.getByText('If this sentence stays').count(), 0, 'nothing is loading any more')
  return opened
}

/** Waits until a chart has drawn its data. */
export async function drawn(page) {
  await page.waitForFunction(() => Number(document.querySelector('.chart')?.dataset.points) > 1)
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))))
}

/** Waits for a page that is drawn a little later than it is asked: until `read` gives `expected`, or the time limit of a page is over. */
export async function becomes(read, expected) {
  const until = performance.now() + 60_000
  for (;;) {
    const actual = await read()
    if (isDeepStrictEqual(actual, expected)) return
    if (performance.now() > until) assert.deepEqual(actual, expected)
    await new Promise((done) => setTimeout(done, 50))
  }
}
