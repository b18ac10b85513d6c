// The trends of points: one axis for each unit, steps for codes, and no mean of a code.

import assert from 'node:assert/strict'
import { test } from 'node:test'
import {
  curveOf,
  linearScale,
  offeredPoints,
  pointAt,
  pointGroups,
  shortNumber,
  stationPoints,
  untilNow,
} from '../dist/test/lib/point-trends.js'

const trend = (name, unit, kind, values, starts = values.map((_, index) => index * 1000)) => ({
  point: { slave: 'turbo', name, unit, kind },
  texts: kind === 'code' ? [{ number: 3, text: 'at speed' }] : [],
  start_ms: starts,
  low: values,
  high: values,
  mean: kind === 'code' ? values.map(() => null) : values,
  last: values,
  qualities: values.map((value) => (value === null ? 1 << 4 : 1)),
})

test('only slaves offer points, by the name of the slave and of the point', () => {
  const parameters = [{ target: 'speed' }, { target: 'state' }]
  const gauges = [
    { name: 'chamber', kind: 'gauge', parameters },
    { name: 'turbo', kind: 'slave', parameters },
  ]
  assert.deepEqual(
    offeredPoints(gauges).map(({ key }) => key),
    ['turbo.speed', 'turbo.state'],
  )
})

test('an archive offers each point once, with its station, by name', () => {
  const archived = [
    { station: 'ring', point: { slave: 'turbo', name: 'speed', unit: 'Hz', kind: 'number' } },
    { station: 'hall', point: { slave: 'turbo', name: 'speed', unit: 'rpm', kind: 'number' } },
    { station: 'hall', point: { slave: 'turbo', name: 'speed', unit: 'Hz', kind: 'number' } },
  ]
  assert.deepEqual(
    stationPoints(archived).map(({ key }) => key),
    ['hall/turbo.speed', 'ring/turbo.speed'],
  )
})

test('numbers with one unit share an axis; a code and a number without a unit have their own', () => {
  const groups = pointGroups([
    trend('speed', 'Hz', 'number', [1000]),
    trend('current', 'A', 'number', [2]),
    trend('set speed', 'Hz', 'number', [990]),
    trend('state', null, 'code', [3]),
    trend('valve', null, 'code', [1]),
    trend('starts', null, 'number', [12]),
    trend('hours', null, 'number', [7]),
  ])
  const names = groups.map(({ trends }) => trends.map(({ point }) => point.name).join())
  assert.deepEqual(names, ['speed,set speed', 'current', 'state', 'valve', 'starts', 'hours'])
  assert.deepEqual(
    groups.map(({ isCode }) => isCode),
    [false, false, true, true, false, false],
  )
})

test('the line of a code is its last value, and that of a number its mean', () => {
  assert.deepEqual(curveOf(trend('state', null, 'code', [3, 1])).mean, [3, 1])
  const speed = { ...trend('speed', 'Hz', 'number', [0, 2]), mean: [0.5, 1.5] }
  assert.deepEqual(curveOf(speed).mean, [0.5, 1.5])
})

test('a curve goes on to the value that the slave shows now, and ends where it shows none', () => {
  const speed = curveOf(trend('speed', 'Hz', 'number', [1000, 1000]))
  assert.deepEqual(untilNow(speed, 990, 40_000).mean, [1000, 1000, 990])
  assert.deepEqual(untilNow(speed, 990, 40_000).start_ms.at(-1), 40_000)
  assert.deepEqual(untilNow(speed, null, 40_000), speed)
})

test('an axis has all numbers of the window, also zero, negative and equal ones', () => {
  const scale = (values, window = [0, 10_000]) => linearScale([curveOf(trend('x', 'A', 'number', values))], window)
  const [low, high] = scale([-2, 0, 8])
  assert.ok(low < -2 && low > -4 && high > 8 && high < 10, `${low} ${high}`)
  const [under, over] = scale([0, 0])
  assert.ok(under < 0 && over > 0)
  assert.deepEqual(scale([null]), [0, 1])
  assert.deepEqual(scale([5], [6000, 7000]), [0, 1])
})

test("a value has its unit, and a code its text in the station's file", () => {
  const state = trend('state', null, 'code', [3, 1])
  assert.equal(pointAt(state, 500, 1000), 'at speed')
  assert.equal(pointAt(state, 1500, 1000), '1')
  const speed = trend('speed', 'Hz', 'number', [1000.25, null])
  assert.equal(pointAt(speed, 500, 1000), '1000.25 Hz')
  assert.equal(pointAt(speed, 3000, 1000), null)
  assert.equal(pointAt(trend('starts', null, 'number', [12]), 0, 1000), '12')
})

test('a number of an axis is short', () => {
  assert.deepEqual([0, -40, 0.1 + 0.2, 60_000, 1_500_000, 0.000_02].map(shortNumber), [
    '0',
    '-40',
    '0.3',
    '60000',
    '1.5e+6',
    '2e-5',
  ])
})
