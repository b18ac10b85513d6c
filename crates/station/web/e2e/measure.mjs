// Measures the dashboard of a plant with 480 gauges in Chromium: `npm run measure`, or `node measure.mjs TIMES`. Prints medians and the longest
// times in milliseconds as JSON, the octets of the live stream for each second, and the load of the computer before.

import { once } from 'node:events'
import { request } from 'node:http'
import { loadavg } from 'node:os'
import { openContext, startBrowser, startPlant } from './setup.mjs'

const times = Number(process.argv[2] ?? 15)

/** How long the live stream is counted, in s. */
const STREAM_S = 20

const summary = (all) => {
  const sorted = all.map(Math.round).sort((one, other) => one - other)
  return { median: sorted[Math.floor(sorted.length / 2)], longest: sorted.at(-1) }
}

/** Runs before the scripts of the page: notes when the first row of a gauge has been painted, and the longest interaction. */
function watch() {
  globalThis.longest = 0
  new PerformanceObserver((list) => {
    for (const { interactionId, duration } of list.getEntries())
      if (interactionId) globalThis.longest = Math.max(globalThis.longest, duration)
  }).observe({ type: 'event', durationThreshold: 16, buffered: true })
  const look = () => {
    const isShown = document.querySelector('.row-readings') !== null
    requestAnimationFrame(isShown ? () => setTimeout(() => (globalThis.firstRow = performance.now())) : look)
  }
  look()
}

/** From an input of the user to the paint of its result, in ms. `expected` is a selector, and how many elements it has then. */
async function delay(page, expected, count, act) {
  await page.evaluate(
    ([expected, count]) => {
      globalThis.result = new Promise((done) => {
        let begun = null
        const begin = ({ timeStamp }) => (begun ??= timeStamp)
        for (const kind of ['pointerdown', 'keydown', 'input', 'change'])
          addEventListener(kind, begin, { capture: true, once: true })
        const look = () => {
          const isShown = begun !== null && document.querySelectorAll(expected).length === count
          requestAnimationFrame(isShown ? () => setTimeout(() => done(performance.now() - begun)) : look)
        }
        look()
      })
    },
    [expected, count],
  )
  await act()
  return page.evaluate(() => globalThis.result)
}

const [browser, plant] = await Promise.all([startBrowser(), startPlant('127.0.0.1:0', 'large')])
const load = loadavg()[0]
const [contents, rows, searches, filters, openings, longest] = [[], [], [], [], [], []]

for (let number = 0; number < times; number += 1) {
  const { page, complaints, close } = await openContext(browser)
  await page.addInitScript(watch)
  await page.goto(plant.url)
  await page.waitForFunction(() => globalThis.firstRow)
  const [painted, row] = await page.evaluate(() => [
    performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? 0,
    globalThis.firstRow,
  ])
  contents.push(painted)
  rows.push(row)
  await page.getByLabel('State').waitFor()
  filters.push(await delay(page, '.row', 1, () => page.getByLabel('State').selectOption('calibration-overdue')))
  await page.getByLabel('State').selectOption('')
  await page.getByLabel('Search gauges').focus()
  await page.keyboard.type('s0')
  searches.push(await delay(page, '.row', 34, () => page.keyboard.press('9')))
  openings.push(await delay(page, '.gauge-labels', 1, () => page.locator('.row a').first().click()))
  longest.push(await page.evaluate(() => globalThis.longest))
  // The made-up gauges of the large plant have no parameters.
  const other = complaints.filter((complaint) => !/status of 404/.test(complaint))
  if (other.length > 0) throw new Error(other.join('\n'))
  await close()
}

// The stream is held by a worker that all windows share; here it is read without a browser, compressed as a browser gets it.
let octets = 0
const stream = request(`${plant.url}/api/live`, { headers: { 'accept-encoding': 'gzip' } }).end()
const [answer] = await once(stream, 'response')
answer.on('data', (part) => {
  octets += part.length
})
// The whole state comes first, in one piece or in several: the changes of the first second count with it.
await new Promise((done) => setTimeout(done, 1000))
const whole = octets
octets = 0
await new Promise((done) => setTimeout(done, STREAM_S * 1000))
const perSecond = Math.round(octets / STREAM_S)
stream.destroy()
await browser.close()
await plant.stop()

console.log(
  JSON.stringify(
    {
      load,
      times,
      firstPaint: summary(contents),
      firstRow: summary(rows),
      filter: summary(filters),
      search: summary(searches),
      openGauge: summary(openings),
      longestInteraction: summary(longest),
      streamBegin: whole,
      streamPerSecond: perSecond,
    },
    null,
    2,
  ),
)
