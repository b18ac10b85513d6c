import assert from 'node:assert/strict'
import { test } from 'node:test'
import {
  choices,
  filterOf,
  filterQuery,
  isFiltered,
  isOverdue,
  NO_LABELS,
  needsLabels,
  passes,
  unknownState,
} from '../dist/test/lib/filter.js'

const ALL = { text: '', group: '', tag: '', location: '', state: '' }
const gauge = { name: 'chamber', segment: 'hall', device: 'bcg450', state: 'data-exchange', readings: [] }
const labels = { ...NO_LABELS, group: 'target', tags: ['bake-out', 'ion'], location: 'rack 4' }
const now = { isAlarmed: false, isFault: false, isStale: false, today: '2026-06-15' }
const does = (filter, more = {}) =>
  passes({ ...ALL, ...filter }, { ...gauge, ...more.gauge }, more.labels ?? labels, { ...now, ...more.now })

test('the address of the page holds the filter', () => {
  const filter = { text: 'a & b', group: 'ring, inside', tag: 'x=1', location: 'hall 2 / rack 4', state: 'no-data' }
  assert.deepEqual(filterOf(new URLSearchParams(filterQuery(filter).toString())), filter)
  assert.equal(filterQuery(ALL).toString(), '')
  assert.deepEqual(filterOf(new URLSearchParams('state=nonsense')), ALL)
  assert.ok(!isFiltered(ALL) && isFiltered({ ...ALL, tag: 'x' }))
})

test('a state in the address that does not exist is told', () => {
  const unknown = (text) => unknownState(new URLSearchParams(text))
  assert.deepEqual(
    [unknown('state=nonsense'), unknown('state=fault'), unknown('state='), unknown('')],
    ['nonsense', null, null, null],
  )
})

test('a gauge passes by its group, tag, location and words, and all of them must hold', () => {
  assert.ok(does({}) && does({ group: 'target' }) && does({ tag: 'ion' }) && does({ location: 'rack 4' }))
  assert.ok(!does({ group: 'Target' }) && !does({ tag: 'bake' }) && !does({ location: 'rack' }))
  assert.ok(does({ text: 'rack bake cham' }) && !does({ text: 'rack 7' }))
  assert.ok(!does({ group: 'target', tag: 'other' }))
  assert.ok(!does({ group: 'target' }, { labels: NO_LABELS }))
})

test('a gauge passes by its state', () => {
  for (const state of ['problems', 'alarms', 'fault', 'no-data', 'calibration-overdue'])
    assert.ok(!does({ state }), state)
  assert.ok(
    does({ state: 'alarms' }, { now: { isAlarmed: true } }) &&
      does({ state: 'problems' }, { now: { isAlarmed: true } }),
  )
  assert.ok(does({ state: 'fault' }, { now: { isFault: true } }))
  assert.ok(
    does({ state: 'no-data' }, { now: { isStale: true } }) && does({ state: 'problems' }, { now: { isStale: true } }),
  )
  assert.ok(does({ state: 'problems' }, { gauge: { state: 'missing' } }))
  assert.ok(does({ state: 'calibration-overdue' }, { labels: { ...labels, calibration_due: '2026-06-14' } }))
})

test('a calibration is overdue from the day after the last day on which it is valid', () => {
  const due = (calibration_due) => isOverdue({ ...labels, calibration_due }, '2026-06-15')
  assert.deepEqual([due(null), due('2026-06-15'), due('2026-06-14'), due('2025-12-31')], [false, false, true, true])
})

test('a choice lists every value once, numbers by their value, with the one that no gauge has', () => {
  assert.deepEqual(choices(['rack 10', null, 'rack 9', 'rack 9'], 'gone'), ['gone', 'rack 9', 'rack 10'])
  assert.ok(needsLabels({ ...ALL, location: 'x' }) && !needsLabels({ ...ALL, text: 'x', state: 'fault' }))
})
