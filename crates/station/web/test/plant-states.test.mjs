import assert from 'node:assert/strict'
import { test } from 'node:test'
import { alarmCount, declaredNames, durationsUpTo, suppressedBy } from '../dist/test/lib/plant-states.js'

const labels = (longest) => durationsUpTo(longest).map(([label]) => label)

test('a plant state offers durations up to its longest time, and that time itself', () => {
  assert.deepEqual(labels(480), ['30 minutes', '1 hour', '4 hours', '8 hours'])
  assert.deepEqual(labels(1), ['1 minute'])
  assert.deepEqual(labels(90), ['30 minutes', '1 hour', '90 minutes'])
  assert.deepEqual(labels(120), ['30 minutes', '1 hour', '2 hours'])
  assert.deepEqual(durationsUpTo(44_640).at(-1), ['31 days', 44_640])
  for (const longest of [1, 30, 61, 1_440, 44_640]) {
    const minutes = durationsUpTo(longest).map(([, minutes]) => minutes)
    assert.deepEqual(
      minutes,
      [...minutes].sort((one, other) => one - other),
    )
    assert.equal(minutes.at(-1), longest)
  }
})

test('the number of alarms and the declared plant states are words', () => {
  assert.equal(alarmCount({ alarms: ['a'] }), '1 alarm')
  assert.equal(alarmCount({ alarms: ['a', 'b'] }), '2 alarms')
  assert.equal(declaredNames([]), '')
  assert.equal(declaredNames([{ name: 'Vented' }, { name: 'Bake-out' }]), 'Vented, Bake-out')
})

test('the alarms of a plant state begin with the active ones, the most urgent first, and end with unknown ones', () => {
  const alarm = (name, priority, state) => ({ name, priority, state, since_ms: 0 })
  const all = [
    alarm('a', 'high', 'normal'),
    alarm('b', 'low', 'acknowledged'),
    alarm('c', 'medium', 'unacknowledged'),
    alarm('d', 'high', 'suppressed'),
    alarm('e', 'high', 'unacknowledged'),
  ]
  const state = { alarms: ['x', 'd', 'a', 'b', 'c'] }
  assert.deepEqual(
    suppressedBy(state, all).map(({ name }) => name),
    ['c', 'b', 'd', 'a', 'x'],
  )
  const names = suppressedBy(state, []).map(({ name, alarm }) => [name, alarm])
  assert.deepEqual(
    names,
    state.alarms.map((name) => [name, null]),
  )
})
