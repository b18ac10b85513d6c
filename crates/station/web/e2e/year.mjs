// How long a chart of a year takes: contrib/archive/year.py runs `node year.mjs ADDRESS TIMES`. The address is that of the chart. Prints medians in
// seconds as JSON: `choice` from the choice of the year on an open page, `opened` from the navigation of a browser without a cache.

import { openPage, startBrowser } from './setup.mjs'

const [address, times] = process.argv.slice(2)

/** The time of the page when the chart has been painted with more than 1000 points, in milliseconds since the navigation. */
const painted = () =>
  new Promise((done) => {
    const look = () => {
      const isDrawn = Number(document.querySelector('.chart')?.dataset.points) > 1000
      requestAnimationFrame(isDrawn ? () => setTimeout(() => done(performance.now())) : look)
    }
    look()
  })

const median = (all) => all.sort((one, other) => one - other)[Math.floor(all.length / 2)]

const browser = await startBrowser()
const [choices, opened] = [[], []]
let points
for (let number = 0; number < Number(times); number += 1) {
  const { page, complaints, close } = await openPage(browser, address)
  opened.push(await page.evaluate(painted))
  points = await page.locator('.chart').getAttribute('data-points')
  const hour = new URL(address)
  const to = Number(hour.searchParams.get('to'))
  hour.searchParams.set('from', String(to - 3_600_000))
  const go = (url) => {
    history.pushState(null, '', url)
    dispatchEvent(new PopStateEvent('popstate'))
  }
  await page.evaluate(go, hour.href)
  await page.waitForFunction(() => Number(document.querySelector('.chart')?.dataset.points) < 1000)
  const begun = await page.evaluate(() => performance.now())
  await page.evaluate(go, address)
  choices.push((await page.evaluate(painted)) - begun)
  if (complaints.length > 0) throw new Error(complaints.join('\n'))
  await close()
}
await browser.close()
console.log(JSON.stringify({ points: Number(points), choice: median(choices) / 1000, opened: median(opened) / 1000 }))
