import assert from 'node:assert/strict'
import { test } from 'node:test'
import {
  alarmsText,
  countsOf,
  isForBothThemes,
  isHidden,
  linesOf,
  namesIn,
  passes,
  shade,
  stateWords,
  topOf,
  volumeState,
  zonesOf,
} from '../dist/test/lib/picture.js'
import { laidOut } from '../dist/test/lib/plant-layout.js'

const reading = (series, quality, pa = null) => ({ series, quality, pa, limit_pa: null })
const gauges = [
  { name: 'ion', readings: [reading('ion', 'off')] },
  { name: 'tpg', readings: [reading('tpg.1', 'underrange'), reading('tpg.2', 'valid', 1)] },
]
const plant = {
  volumes: [
    { name: 'chamber', zone: 'target', gauges: ['ion', 'tpg', 'lost'] },
    { name: 'fore line', zone: null, gauges: ['tpg.2'] },
  ],
  parts: [
    { name: 'gate', kind: 'valve', volumes: ['chamber', 'fore line'] },
    { name: 'scroll', kind: 'roughing-pump', volumes: ['fore line'] },
    { name: 'flange', kind: 'leak', volumes: ['chamber'] },
  ],
}
const alarm = (gauge, series, priority, state = 'unacknowledged') => ({ gauge, series, priority, state })
const stateOf = (volume, alarms = []) =>
  volumeState(volume, namesIn(plant), gauges, alarms, (_, { quality }) => quality)

test('a channel that another volume names belongs to that volume alone', () => {
  const [chamber, foreLine] = plant.volumes.map((volume) => stateOf(volume))
  assert.deepEqual(
    chamber.readings.map(({ reading }) => reading.series),
    ['ion', 'tpg.1'],
  )
  assert.deepEqual(
    foreLine.readings.map(({ reading }) => reading.series),
    ['tpg.2'],
  )
  assert.deepEqual(chamber.silent, ['lost'])
})

test('the leading reading is a valid one, then one beyond its range, then the first', () => {
  const [chamber, foreLine] = plant.volumes.map((volume) => stateOf(volume))
  assert.equal(foreLine.leading.reading.series, 'tpg.2')
  assert.equal(chamber.leading.reading.series, 'tpg.1')
  const alone = stateOf({ name: 'a', zone: null, gauges: ['ion'] })
  assert.equal(alone.leading.quality, 'off')
  assert.equal(stateOf({ name: 'b', zone: null, gauges: ['lost'] }).leading, null)
})

test('an alarm belongs to the volume of its channel, and one that has cleared to none', () => {
  const alarms = [
    alarm('tpg', 'tpg.2', 'high'),
    alarm('ion', null, 'low'),
    alarm('ion', 'ion', 'medium', 'returned'),
    alarm('tpg', null, 'low'),
  ]
  const [chamber, foreLine] = plant.volumes.map((volume) => stateOf(volume, alarms))
  assert.equal(alarmsText(foreLine.alarms), 'alarms: 1 high')
  assert.equal(alarmsText(chamber.alarms), 'alarms: 2 low')
  assert.equal(alarmsText([]), '')
})

test('shades run over the decades from 1e-8 Pa to the atmosphere', () => {
  assert.deepEqual([1e-9, 1e-8, 1e5, 1e6].map(shade), [0, 0, 1, 1])
  assert.ok(Math.abs(shade(10 ** -1.5) - 0.5) < 1e-9)
  assert.deepEqual([shade(null), shade(0)], [null, null])
})

test('a part without a report says so, and never looks open or closed', () => {
  const [gate, scroll, flange] = plant.parts
  assert.equal(stateWords(gate, undefined), 'not reported')
  assert.equal(passes(gate, undefined), null)
  assert.equal(stateWords(gate, { state: 'closed', detail: null }), 'closed')
  assert.equal(stateWords(scroll, { state: 'running', detail: '98 %' }), 'runs 98 %')
  assert.equal(stateWords(flange, { state: 'open', detail: null }), 'leaks')
  assert.equal(passes(scroll, { state: 'stopped', detail: null }), false)
})

test('the layout places every volume and part without overlap, in both directions, and lines end at symbols', () => {
  assert.deepEqual(zonesOf(plant), ['target'])
  for (const direction of ['LR', 'TB']) {
    const { boxes, symbols, lines, zones, width, height } = laidOut(plant, direction)
    assert.equal(boxes.size, 5)
    const all = [...boxes.values()]
    for (const [index, one] of all.entries()) {
      assert.ok(one.x - one.width / 2 >= 0 && one.x + one.width / 2 <= width, `${direction} ${index}`)
      assert.ok(one.y - one.height / 2 >= 0 && one.y + one.height / 2 <= height, `${direction} ${index}`)
      for (const other of all.slice(index + 1)) {
        const isApart =
          Math.abs(one.x - other.x) >= (one.width + other.width) / 2 ||
          Math.abs(one.y - other.y) >= (one.height + other.height) / 2
        assert.ok(isApart, direction)
      }
    }
    assert.equal(zones[0].name, 'target')
    assert.equal(lines.length, plant.parts.flatMap(linesOf).length)
    const gate = symbols.get('gate')
    assert.deepEqual(
      [lines[0].points.at(-1), lines[1].points[0]].map(({ x, y }) => [x, y]),
      [
        [gate.x, gate.y],
        [gate.x, gate.y],
      ],
    )
  }
})

test('a volume has its source beside the number of its readings that have no pressure', () => {
  const stateOf = (qualities, silent) => {
    const placed = qualities.map((quality, index) => ({ quality, reading: reading(`s${index}`, quality, 1) }))
    return { readings: placed, leading: placed[0] ?? null, silent, alarms: [] }
  }
  // A bound is no word: the pressure is below or above it.
  assert.deepEqual(countsOf(stateOf(['valid', 'underrange', 'overrange', 'fault', 'stale', 'off'], ['lost'])), {
    shown: 's0',
    all: 7,
    without: 4,
  })
  assert.deepEqual(countsOf(stateOf(['stale', 'stale'], [])), { shown: 's0', all: 2, without: 2 })
  // A gauge that never had data is named.
  assert.deepEqual(countsOf(stateOf([], ['ion'])), { shown: 'ion', all: 1, without: 1 })
  assert.deepEqual(countsOf(stateOf([], [])), { shown: '', all: 0, without: 0 })
})

test('a hidden leak leaves no room above the picture', () => {
  const flange = plant.parts[2]
  assert.ok(isHidden(flange, { state: 'closed', detail: null }))
  assert.ok(!isHidden(flange, { state: 'open', detail: null }) && !isHidden(flange, undefined))
  const layout = laidOut({ ...plant, volumes: plant.volumes.map((volume) => ({ ...volume, zone: null })) }, 'TB')
  const highest = (ids) => Math.min(...ids.map((id) => layout.boxes.get(id)).map(({ y, height }) => y - height / 2))
  assert.equal(topOf(layout, [flange]), highest(['volume chamber']) - 8)
  assert.equal(topOf(layout, []), 0)
  assert.ok(highest(['volume chamber']) - 8 > 50)
  assert.equal(topOf(laidOut(plant, 'LR'), [flange]), 0)
})

test('a line that goes down is straight where its volume is above or below its symbol', () => {
  const { lines, symbols } = laidOut(plant, 'TB')
  for (const { part, points } of lines.filter(({ points }) => points.length <= 4))
    assert.ok(
      points.every(({ x }) => x === symbols.get(part).x),
      `${part}: ${JSON.stringify(points)}`,
    )
})

test('a part between two volumes of a zone is in the frame of the zone, which has room for its name', () => {
  const inZone = {
    volumes: [
      { name: 'chamber', zone: 'target', gauges: [] },
      { name: 'lock', zone: 'target', gauges: [] },
    ],
    parts: [{ name: 'gate', kind: 'valve', volumes: ['chamber', 'lock'] }],
  }
  for (const direction of ['LR', 'TB']) {
    const { boxes, zones } = laidOut(inZone, direction)
    const [{ box }] = zones
    const top = box.y - box.height / 2
    assert.ok(top >= 0)
    for (const [name, { x, y, width, height }] of boxes) {
      const isInside =
        Math.abs(x - box.x) + width / 2 <= box.width / 2 && Math.abs(y - box.y) + height / 2 <= box.height / 2
      assert.ok(isInside, `${direction} ${name}`)
      if (name.startsWith('volume')) assert.ok(y - height / 2 - top >= 20, `${direction} ${name} under the name`)
    }
    const [first, gate, last] = ['volume chamber', 'part gate', 'volume lock'].map((name) => boxes.get(name))
    const [along, size] = direction === 'LR' ? ['x', 'width'] : ['y', 'height']
    assert.ok(gate[along] - gate[size] / 2 >= first[along] + first[size] / 2, `${direction}: the valve is between`)
    assert.ok(gate[along] + gate[size] / 2 <= last[along] - last[size] / 2, `${direction}: the valve is between`)
  }
})

test('a drawing is for both themes only if its first element says so', () => {
  const both = 'style="fill:none; color-scheme: light dark"'
  assert.deepEqual(
    [
      `<svg viewBox="0 0 9 9" ${both}></svg>`,
      '<svg></svg>',
      '<svg style="color-scheme:light"></svg>',
      `<svg><g ${both}></g></svg>`,
    ].map(isForBothThemes),
    [true, false, false, false],
  )
})
