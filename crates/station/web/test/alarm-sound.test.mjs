import assert from 'node:assert/strict'
import { test } from 'node:test'
import { silencedOf, silencing, soundingPriority, TONES } from '../dist/test/lib/alarm-sound.js'

const NONE = new Set()
const alarm = (name, priority, state = 'unacknowledged', occurrence = 1) => ({ name, priority, state, occurrence })

test('the highest priority of the active alarms that are not acknowledged sounds', () => {
  assert.equal(soundingPriority([], NONE), null)
  assert.equal(soundingPriority([alarm('a', 'low'), alarm('b', 'medium')], NONE), 'medium')
  const quiet = [alarm('a', 'high', 'acknowledged'), alarm('b', 'high', 'returned'), alarm('c', 'high', 'shelved')]
  assert.equal(soundingPriority([...quiet, alarm('d', 'low')], NONE), 'low')
})

test('silence lasts until another alarm is raised, or the same one again', () => {
  const [first, second] = [alarm('a', 'high'), alarm('b', 'low')]
  const silenced = silencing([first])
  assert.equal(soundingPriority([first], silenced), null)
  assert.equal(soundingPriority([first, second], silenced), 'low')
  assert.equal(soundingPriority([alarm('a', 'high', 'unacknowledged', 2)], silenced), 'high')
  assert.deepEqual([...silencing([second, alarm('c', 'low', 'acknowledged')])], ['1 b'], 'ended ones are forgotten')
})

test('each priority has a pitch, a number of pulses and a pause of its own, and is over before it is repeated', () => {
  const tones = ['high', 'medium', 'low'].map((priority) => TONES[priority])
  for (const key of ['hertz', 'pulses', 'everyMs']) assert.equal(new Set(tones.map((tone) => tone[key])).size, 3, key)
  for (const { pulses, everyMs } of tones) assert.ok(pulses * 250 < everyMs)
})

test('what the browser keeps of silenced alarms may be anything', () => {
  assert.deepEqual([...silencedOf('["1 a"]')], ['1 a'])
  for (const text of [null, '', 'x', '{}', '[1]']) assert.deepEqual([...silencedOf(text)], [], String(text))
})
