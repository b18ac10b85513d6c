import assert from 'node:assert/strict'
import { test } from 'node:test'
import { activeCounts, countsText, lowerText, moreUrgent, summary } from '../dist/test/lib/alarms.js'
import { merged, snapshotOf } from '../dist/test/lib/merge.js'

const reading = (series, instance, pa) => ({ series, instance, pa, quality: 'valid' })
const state = () => ({
  station: { name: 'hall', now_ms: 1 },
  segments: { hall: { name: 'hall' } },
  gauges: {
    b: { name: 'b', readings: { 'b.10': reading('b.10', 10, 1), 'b.2': reading('b.2', 2, 2) } },
    a: { name: 'a', readings: { a: reading('a', 0, 3) } },
  },
  gauge_order: ['b', 'a'],
  alarms: { problem: null, alarms: { late: { name: 'late' }, first: { name: 'first' } }, order: ['first', 'late'] },
  plant: {
    revision: 1,
    states: { gate: { state: 'open', detail: null }, turbo: { state: 'running', detail: '98 %' } },
    story: [],
  },
})

test('a change alters what it names and keeps the rest', () => {
  const before = state()
  const after = merged(before, { station: { now_ms: 2 }, gauges: { a: { readings: { a: { pa: 4 } } } } })
  assert.equal(after.gauges.a.readings.a.pa, 4)
  assert.equal(after.station.name, 'hall')
  assert.equal(before.gauges.a.readings.a.pa, 3)
  assert.equal(after.gauges.b, before.gauges.b)
})

test('a property without a value is null, and a removed gauge is gone', () => {
  const after = merged(state(), {
    gauges: { a: null, b: { readings: { 'b.2': { pa: null } } } },
    gauge_order: ['b'],
  })
  const { gauges } = snapshotOf(after)
  assert.deepEqual(
    gauges.map(({ name }) => name),
    ['b'],
  )
  assert.equal(gauges[0].readings[0].pa, null)
})

test('a part of the plant that reports no state any more has none', () => {
  const { plant } = snapshotOf(merged(state(), { plant: { states: { gate: null, turbo: { detail: null } } } }))
  assert.deepEqual(plant.states, { turbo: { state: 'running', detail: null } })
})

test('gauges, channels and alarms have the order of the station', () => {
  const { gauges, alarms } = snapshotOf(state())
  assert.deepEqual(
    gauges.map(({ name, readings }) => [name, ...readings.map(({ series }) => series)]),
    [
      ['b', 'b.2', 'b.10'],
      ['a', 'a'],
    ],
  )
  assert.deepEqual(
    alarms.alarms.map(({ name }) => name),
    ['first', 'late'],
  )
})

test('a gauge without a change is not drawn again', () => {
  const before = state()
  const after = merged(before, { gauges: { a: { readings: { a: { pa: 4 } } } } })
  assert.equal(snapshotOf(after).gauges[0], snapshotOf(before).gauges[0])
})

test('a gauge may be called __proto__', () => {
  const patch = JSON.parse(
    '{"gauges": {"__proto__": {"name": "__proto__", "readings": {}}}, "gauge_order": ["__proto__"]}',
  )
  assert.deepEqual(
    snapshotOf(merged(state(), patch)).gauges.map(({ name }) => name),
    ['__proto__'],
  )
  assert.equal({}.name, undefined)
})

test('alarms are counted by priority, the highest first, and only the active ones', () => {
  const alarm = (priority, state = 'acknowledged') => ({ priority, state })
  const counts = activeCounts([
    alarm('medium'),
    alarm('high'),
    alarm('medium'),
    alarm('low'),
    alarm('high', 'returned'),
  ])
  assert.equal(countsText(counts), '1 high, 2 medium, 1 low')
  assert.deepEqual([countsText([]), countsText(counts.slice(1))], ['', '2 medium, 1 low'])
  const [, ...lower] = counts
  assert.deepEqual([lower, lower.slice(1), []].map(lowerText), ['3 more', '1 low', ''])
  const live = { high: { active: 1, unacknowledged: 0 }, medium: { active: 3, unacknowledged: 4 } }
  const { active, unacknowledged } = summary({ ...live, low: { active: 0, unacknowledged: 0 } })
  assert.deepEqual([countsText(active), unacknowledged], ['1 high, 3 medium', 4])
})

test('a high alarm that has cleared gives the header no colour', () => {
  const counts = (active, unacknowledged) => ({ active, unacknowledged })
  const alarms = { high: counts(0, 1), medium: counts(0, 0), low: counts(0, 0) }
  assert.deepEqual(summary(alarms).active, [])
  assert.deepEqual(summary({ ...alarms, low: counts(1, 0) }).active, [{ priority: 'low', count: 1 }])
  assert.equal(summary({ ...alarms, high: counts(0, 0) }), null)
  const waiting = (high) => moreUrgent(summary({ ...alarms, high, medium: counts(2, 2) }))
  assert.deepEqual(waiting(counts(0, 1)), { priority: 'high', count: 1 }, 'it has cleared')
  assert.equal(waiting(counts(1, 1)), null, 'an active one says so itself')
})
