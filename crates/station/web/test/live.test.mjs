import assert from 'node:assert/strict'
import { test } from 'node:test'
import { activeCounts, countsText, lowerText, moreUrgent, summary } from '../dist/test/lib/alarms.js'
import { changed } from '../dist/test/lib/changes.js'
import { snapshotOf } from '../dist/test/lib/merge.js'

const gauge = (name, pa) => ({ name, readings: [{ series: name, instance: 0, pa, quality: 'valid' }] })
const state = () => ({
  station: { name: 'hall', now_ms: 1 },
  segments: { hall: { name: 'hall' } },
  gauges: { a: gauge('a', 3), b: gauge('b', 1) },
  gauge_order: ['b', 'a'],
  alarms: { problem: null },
  standing_alarms: {},
  plant: { revision: 1, states: { gate: { state: 'open', detail: null } }, story: [] },
})
const after = (before, change) => changed(before, change, ['segments', 'gauges', 'standing_alarms'])
const names = ({ gauges }) => gauges.map(({ name }) => name)

test('a change replaces the parts and the gauges that it has and keeps the rest', () => {
  const before = state()
  const made = after(before, { station: { name: 'hall', now_ms: 2 }, gauges: { a: gauge('a', null) } })
  assert.deepEqual(made, {
    ...state(),
    station: { name: 'hall', now_ms: 2 },
    gauges: { a: gauge('a', null), b: gauge('b', 1) },
  })
  assert.deepEqual(before, state(), 'the old state stays as it is')
})

test('a removed gauge is gone', () => {
  const made = after(state(), { gauges: { a: null }, gauge_order: ['b'] })
  assert.deepEqual([Object.keys(made.gauges), names(snapshotOf(made))], [['b'], ['b']])
})

test('a part of the plant that reports no state any more has none', () => {
  const { plant } = snapshotOf(after(state(), { plant: { revision: 1, states: {}, story: [] } }))
  assert.deepEqual(plant.states, {})
})

test('gauges have the order of the station, and segments are a list', () => {
  const snapshot = snapshotOf(state())
  assert.deepEqual([names(snapshot), snapshot.segments], [['b', 'a'], [{ name: 'hall' }]])
})

test('each alarm of a flood is in the snapshot, the most urgent first, and one that has ended is gone', () => {
  const alarm = (name, priority) => ({ name, priority, state: 'unacknowledged', since_ms: 1 })
  const low = Array.from({ length: 400 }, (_, number) => alarm(`low ${number}`, 'low'))
  const flood = Object.fromEntries([...low, alarm('vented', 'high')].map((alarm) => [alarm.name, alarm]))
  const flooded = after(state(), { standing_alarms: flood })
  const listed = snapshotOf(flooded).alarms.alarms
  assert.deepEqual([listed.length, listed[0].name], [401, 'vented'])
  const ended = after(flooded, { standing_alarms: { vented: null, 'low 7': null } })
  assert.deepEqual([snapshotOf(ended).alarms.alarms.length, snapshotOf(ended).alarms.alarms[0].priority], [399, 'low'])
})

test('a gauge without a change is not drawn again', () => {
  const before = state()
  assert.equal(snapshotOf(after(before, { gauges: { a: gauge('a', 4) } })).gauges[0], snapshotOf(before).gauges[0])
})

test('a gauge may be called __proto__', () => {
  const change = JSON.parse(
    '{"gauges": {"__proto__": {"name": "__proto__", "readings": []}}, "gauge_order": ["__proto__"]}',
  )
  assert.deepEqual(names(snapshotOf(after(state(), change))), ['__proto__'])
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
