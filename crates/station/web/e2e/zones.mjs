// A station with three zones and sixteen gauges in memory: the target has an alarm of high priority, the source one of low priority, the beam line
// is quiet. Its plant is laid out by the dashboard, or shown by a drawing of one's own.

import { mkdtemp, rm, writeFile } from 'node:fs/promises'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { startStation } from './setup.mjs'

/** Each segment has a pressure of its own, and gauges: name, device, zone. */
const SEGMENTS = {
  source: {
    pressure: '4e-5 mbar',
    gauges: [
      ['source ion', 'bcg450', 'source'],
      ['source pirani', 'pcg550', 'source'],
      ['extraction ion', 'bpg400', 'source'],
    ],
  },
  'beam line': {
    pressure: '3e-8 mbar',
    gauges: [
      ['line 1 ion', 'bcg450', 'beam line'],
      ['line 2 ion', 'bcg450', 'beam line'],
      ['line 2 hot', 'bpg400', 'beam line'],
      ['line 3 ion', 'bcg450', 'beam line'],
    ],
  },
  target: {
    pressure: '6e-3 mbar',
    gauges: [
      ['target ion', 'bcg450', 'target'],
      ['target pirani', 'pcg550', 'target'],
      ['target hot', 'bpg400', 'target'],
    ],
  },
  lock: {
    pressure: '1013 mbar',
    gauges: [
      ['lock pirani', 'pcg550', 'target'],
      ['lock combined', 'bcg450', 'target'],
    ],
  },
  'fore vacuum': {
    pressure: '2e-2 mbar',
    gauges: [
      ['source fore line', 'pcg550', 'source'],
      ['line fore line', 'pcg550', 'beam line'],
      ['target fore line', 'pcg550', 'target'],
      ['roots inlet', 'psg550', ''],
    ],
  },
}

const ALARMS = `
[[alarm]]
name = "target not evacuated"
gauge = "target ion"
above = "1e-4 mbar"
delay = "0 s"
priority = "high"
message = "Keep gate 3 closed and call the vacuum group."

[[alarm]]
name = "target backing high"
gauge = "target fore line"
above = "1e-2 mbar"
delay = "0 s"
priority = "low"

[[alarm]]
name = "source above 1e-5 mbar"
gauge = "source ion"
above = "1e-5 mbar"
delay = "0 s"
priority = "low"

[[alarm]]
name = "beam line not evacuated"
gauge = "line 2 ion"
above = "1e-6 mbar"
delay = "0 s"
priority = "high"
`

const PLANT = `
${volume('ion source', 'source', ['source ion', 'source pirani'])}
${volume('extraction', 'source', ['extraction ion'])}
${volume('line 1', 'beam line', ['line 1 ion'])}
${volume('line 2', 'beam line', ['line 2 ion', 'line 2 hot'])}
${volume('line 3', 'beam line', ['line 3 ion'])}
${volume('target chamber', 'target', ['target ion', 'target hot', 'target pirani'])}
${volume('load lock', 'target', ['lock combined', 'lock pirani'])}
${volume('source backing', 'source', ['source fore line'])}
${volume('line backing', 'beam line', ['line fore line'])}
${volume('target backing', 'target', ['target fore line'])}
${volume('fore line', '', ['roots inlet'])}
${valve('aperture', 'ion source', 'extraction')}
${valve('gate 1', 'extraction', 'line 1')}
${valve('sector 1', 'line 1', 'line 2')}
${valve('sector 2', 'line 2', 'line 3')}
${valve('gate 3', 'line 3', 'target chamber')}
${valve('lock valve', 'target chamber', 'load lock')}
${valve('source backing valve', 'source backing', 'fore line')}
${valve('line backing valve', 'line backing', 'fore line')}
${valve('target backing valve', 'target backing', 'fore line')}
${pump('source turbo', 'turbo', 'ion source', 'source backing')}
${pump('line turbo', 'turbo', 'line 2', 'line backing')}
${pump('line getter', 'capture', 'line 3')}
${pump('target turbo', 'turbo', 'target chamber', 'target backing')}
${pump('lock scroll', 'roughing', 'load lock')}
${pump('scroll', 'roughing', 'fore line')}
`

/** The same plant as an engineer draws it. */
const DRAWING = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1000 460">
<style>
  text { font: bold 17px sans-serif; text-anchor: middle }
  .name { font: 15px sans-serif; fill: #777 }
</style>
<path fill="none" stroke="#888" stroke-width="6" d="M60 130H940 M130 200V390H780V200 M450 160V390 M450 390V430"/>
${drawnVolume('ion source', 40, 80, 180, 120, 'source ion')}
${drawnVolume('line 2', 350, 100, 200, 70, 'line 2 ion')}
${drawnVolume('target chamber', 680, 60, 200, 150, 'target ion')}
${drawnVolume('fore line', 350, 360, 200, 60, 'roots inlet')}
${drawnValve('gate 1', 285, 130)}
${drawnValve('gate 3', 615, 130)}
${drawnValve('source backing valve', 210, 390)}
${drawnPump('source turbo', 130, 290)}
${drawnPump('line turbo', 450, 265)}
${drawnPump('target turbo', 780, 290)}
</svg>`

function volume(name, zone, gauges) {
  return `[[volume]]\nname = "${name}"\n${zone && `zone = "${zone}"\n`}gauges = ${JSON.stringify(gauges)}\n`
}

function valve(name, ...between) {
  return `[[valve]]\nname = "${name}"\nbetween = ${JSON.stringify(between)}\n`
}

function pump(name, kind, inlet, outlet) {
  return `[[pump]]\nname = "${name}"\nkind = "${kind}"\ninlet = "${inlet}"\n${outlet ? `outlet = "${outlet}"\n` : ''}`
}

function id(kind, name) {
  return `${kind}:${name.replaceAll(' ', '_')}`
}

function drawnVolume(name, x, y, width, height, gauge) {
  const middle = x + width / 2
  return `<rect id="${id('volume', name)}" fill="#fff" stroke="#777" stroke-width="2" x="${x}" y="${y}" width="${width}" height="${height}" rx="8"/>
<text class="name" x="${middle}" y="${y + 24}">${name}</text>
<text id="${id('gauge', gauge)}" fill="#222" x="${middle}" y="${y + height / 2 + 14}">${gauge}</text>`
}

function drawnValve(name, x, y) {
  return `<path id="${id('valve', name)}" fill="#fff" stroke="#777" stroke-width="2" d="M${x - 20} ${y - 14}L${x + 20} ${y + 14}V${y - 14}L${x - 20} ${y + 14}Z"/>
<text class="name" x="${x}" y="${y + 36}">${name}</text>`
}

function drawnPump(name, x, y) {
  return `<circle id="${id('pump', name)}" fill="#fff" stroke="#777" stroke-width="2" cx="${x}" cy="${y}" r="26"/>
<text class="name" x="${x + 90}" y="${y + 5}">${name}</text>`
}

function segment([name, { gauges }], index) {
  const lines = gauges.map(
    ([gauge, device, zone], place) =>
      `[[segment.gauge]]\nname = "${gauge}"\naddress = ${5 + place}\ndevice = "${device}"\n${zone && `group = "${zone}"\n`}`,
  )
  return `[[segment]]\nname = "${name}"\nport = "sim:line-${index}.toml"\n${lines.join('')}`
}

/** The gauges of a segment, as its file describes them. */
function line({ pressure, gauges }) {
  const devices = gauges.map(([, device], place) => `${device}@${5 + place}`)
  return `devices = ${JSON.stringify(devices)}\npressure = "${pressure}"\n`
}

/** Starts the station, with a drawing of one's own if it is wanted. Stopping it also removes its files. */
export async function startZones({ isDrawn = false } = {}) {
  const folder = await mkdtemp(join(tmpdir(), 'profivac-zones-'))
  const head = `[station]\nname = "Accelerator"\n${isDrawn ? 'drawing = "plant.svg"\n' : ''}`
  const segments = Object.entries(SEGMENTS).map(segment)
  const files = { 'plant.toml': [head, ...segments, ALARMS, PLANT].join('\n'), 'plant.svg': DRAWING }
  for (const [index, one] of Object.values(SEGMENTS).entries()) files[`line-${index}.toml`] = line(one)
  for (const [name, text] of Object.entries(files)) await writeFile(join(folder, name), text, { mode: 0o600 })
  const station = await startStation(join(folder, 'plant.toml'))
  return {
    ...station,
    stop: async () => {
      await station.stop()
      await rm(folder, { recursive: true, force: true })
    },
  }
}
