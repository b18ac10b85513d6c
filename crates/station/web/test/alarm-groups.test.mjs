import assert from 'node:assert/strict'
import { test } from 'node:test'
import {
  alarmGroups,
  FEW_ALARMS,
  hasHeading,
  isFiltered,
  mustAsk,
  NO_FILTER,
  openGroups,
  passesFilter,
  passing,
  placeOf,
  summaryOf,
  valuesOf,
} from '../dist/test/lib/alarm-groups.js'
import { volumesOfAlarms } from '../dist/test/lib/picture.js'

const alarm = (name, more = {}) => ({
  name,
  priority: 'medium',
  state: 'unacknowledged',
  gauge: null,
  series: null,
  segment: null,
  several: null,
  raised_ms: 0,
  since_ms: 0,
  ...more,
})
const gauges = [
  { name: 'ion', readings: [{ series: 'ion' }] },
  { name: 'tpg', readings: [{ series: 'tpg.1' }, { series: 'tpg.2' }] },
  { name: 'spare', readings: [{ series: 'spare' }] },
]
const plant = {
  volumes: [
    { name: 'chamber', zone: null, gauges: ['ion', 'tpg'] },
    { name: 'fore line', zone: null, gauges: ['tpg.2'] },
  ],
  parts: [],
}
const place = (one) => placeOf(one, volumesOfAlarms(plant, gauges))
const groups = (...alarms) => alarmGroups(alarms, place)
const names = (list) => list.map(({ alarms }) => alarms.map(({ name }) => name))

test('an alarm is in the volume of its gauge or channel, otherwise at its gauge, its segment or the station', () => {
  const several = (...series) => alarm('a', { several: { series } })
  for (const [one, key] of [
    [alarm('a', { gauge: 'ion', series: 'ion' }), 'volume chamber'],
    [alarm('a', { gauge: 'tpg', series: 'tpg.1' }), 'volume chamber'],
    [alarm('a', { gauge: 'tpg', series: 'tpg.2' }), 'volume fore line'],
    // A fault of the controller.
    [alarm('a', { gauge: 'tpg' }), 'volume chamber'],
    [alarm('a', { gauge: 'ion', state: 'returned' }), 'volume chamber'],
    [alarm('a', { gauge: 'spare', series: 'spare' }), 'gauge spare'],
    [alarm('a', { segment: 'hall' }), 'segment hall'],
    [alarm('a'), 'station '],
    [several('ion', 'tpg.1'), 'volume chamber'],
    [several('ion', 'tpg.2'), 'station '],
  ])
    assert.equal(groups(one)[0].key, key, JSON.stringify(one))
  assert.deepEqual(
    placeOf(alarm('a', { gauge: 'ion' }), () => null),
    { kind: 'gauge', name: 'ion' },
  )
})

test('the group with the most urgent alarm comes first, and so does the most urgent alarm in it', () => {
  const found = groups(
    alarm('low', { gauge: 'ion', priority: 'low' }),
    alarm('medium', { gauge: 'spare' }),
    alarm('high', { gauge: 'ion', priority: 'high' }),
  )
  assert.deepEqual(names(found), [['high', 'low'], ['medium']])
  assert.deepEqual(found.map(hasHeading), [true, false])
})

test('the first alarm of a group is the one raised first of those active now', () => {
  const [group] = groups(
    alarm('cleared', { gauge: 'ion', state: 'returned', raised_ms: 1 }),
    alarm('late', { gauge: 'ion', priority: 'high', raised_ms: 9 }),
    alarm('early', { gauge: 'ion', state: 'acknowledged', raised_ms: 5 }),
  )
  assert.equal(group.first.name, 'early')
  const [cleared] = groups(
    alarm('a', { gauge: 'ion', state: 'returned' }),
    alarm('b', { gauge: 'ion', state: 'returned' }),
  )
  assert.equal(cleared.first, null)
  assert.deepEqual(summaryOf(cleared.alarms), {
    active: [],
    unacknowledgedCounts: [{ priority: 'medium', count: 2 }],
    unacknowledged: 2,
  })
})

test('a filter leaves the groups in order, and what was raised first', () => {
  const all = groups(
    alarm('high', { gauge: 'ion', priority: 'high', raised_ms: 2 }),
    alarm('old', { gauge: 'ion', raised_ms: 1, since_ms: 1 }),
    alarm('new', { gauge: 'spare', raised_ms: 3, since_ms: 3 }),
  )
  const medium = passing(all, ({ priority }) => priority === 'medium')
  assert.deepEqual(names(medium), [['new'], ['old']])
  assert.equal(medium[1].first.name, 'old')
  const high = passing(all, ({ priority }) => priority === 'high')
  assert.deepEqual(names(high), [['high']])
  assert.equal(high[0].first.name, 'old')
})

test('the filter takes a priority, and words of the alarm, its gauge, its place and its location', () => {
  const one = alarm('too high', { gauge: 'ion', series: 'ion', priority: 'low' })
  const passes = (filter) => passesFilter(one, { ...NO_FILTER, ...filter }, place(one), 'hall, platform')
  for (const text of ['', ' ', 'HIGH', 'ion', 'chamber', 'platform', 'ion hall ']) assert.ok(passes({ text }), text)
  assert.ok(!passes({ text: 'ion tunnel' }))
  assert.ok(passes({ priority: 'low' }) && !passes({ priority: 'high' }))
  assert.ok(!passesFilter(one, { ...NO_FILTER, text: 'null' }, place(one), null))
  assert.deepEqual([NO_FILTER, { priority: '', text: ' ' }, { priority: 'low', text: '' }].map(isFiltered), [
    false,
    false,
    true,
  ])
})

test('the groups of a short list are open, and a choice of the user stays as long as the group', () => {
  const two = groups(alarm('a', { gauge: 'ion' }), alarm('b', { gauge: 'ion' }), alarm('c', { gauge: 'spare' }))
  const none = new Map()
  const open = (before, list, isShort) => openGroups(before, list, isShort).get('volume chamber')?.open
  // A group of one alarm is neither.
  assert.deepEqual([...openGroups(none, two, true).keys()], ['volume chamber'])
  assert.deepEqual([open(none, two, true), open(none, two, false)], [true, false])
  // A list that becomes long closes nothing, one that becomes short opens.
  assert.equal(open(openGroups(none, two, true), two, false), true)
  assert.equal(open(openGroups(none, two, false), two, true), true)
  for (const chosen of [true, false]) {
    const before = new Map([['volume chamber', { open: chosen, chosen: true }]])
    assert.deepEqual([open(before, two, true), open(before, two, false)], [chosen, chosen])
    assert.equal(open(openGroups(before, [], true), two, true), true)
  }
})

test('the page asks before it acknowledges what a user may not have seen', () => {
  const list = groups(alarm('a', { gauge: 'ion' }), alarm('b', { gauge: 'ion', state: 'acknowledged' }), alarm('c'))
  const [a, , c] = ['a', 'b', 'c'].map((name) => list.flatMap(({ alarms }) => alarms).find((one) => one.name === name))
  const isOpen = (group) => !hasHeading(group)
  assert.equal(mustAsk([a, c], list, isOpen), true)
  assert.equal(
    mustAsk([a, c], list, () => true),
    false,
  )
  // Nothing in the closed group waits.
  assert.equal(mustAsk([c], list, isOpen), false)
  const many = Array.from({ length: FEW_ALARMS + 1 }, (_, index) => alarm(`${index}`))
  assert.equal(
    mustAsk(many, groups(...many), () => true),
    true,
  )
  assert.equal(
    mustAsk(many.slice(1), groups(...many), () => true),
    false,
  )
})

test('an alarm without a value in the snapshot has that of the list of all alarms', () => {
  const all = [alarm('a', { value: 1 }), alarm('b', { value: 2 }), alarm('c', { value: null })]
  const shown = [
    alarm('b', { value: null }),
    alarm('a', { value: 9 }),
    alarm('c', { value: null }),
    alarm('new', { value: null }),
  ]
  const presentValue = valuesOf(all)
  const values = shown.map((alarm) => [alarm.name, presentValue(alarm)])
  assert.deepEqual(values, [
    ['b', 2],
    ['a', 9],
    ['c', null],
    ['new', null],
  ])
})
