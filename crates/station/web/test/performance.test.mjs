import assert from 'node:assert/strict'
import { test } from 'node:test'
import { sharesOf } from '../dist/test/lib/performance.js'

/** The shares of so many alarms of high, medium and low priority. */
const shares = (high, medium, low) => sharesOf({ raised: high + medium + low, by_priority: { high, medium, low } })
const beyond = (...counts) =>
  shares(...counts)
    .filter(({ isBeyond }) => isBeyond)
    .map(({ priority }) => priority)

test('the shares of the priorities stand beside the recommended ones', () => {
  assert.deepEqual(
    shares(1, 3, 16).map(({ priority, percent, recommended }) => [priority, percent, recommended]),
    [
      ['high', 5, 5],
      ['medium', 15, 15],
      ['low', 80, 80],
    ],
  )
  assert.deepEqual(
    shares(0, 0, 0).map(({ percent }) => percent),
    [null, null, null],
  )
})

test('a share is beyond the recommendation when too many alarms are urgent', () => {
  assert.deepEqual(beyond(5, 15, 80), [])
  assert.deepEqual(beyond(75, 175, 750), ['low'])
  assert.deepEqual(beyond(75, 150, 775), [])
  assert.deepEqual(beyond(76, 149, 775), ['high'])
  assert.deepEqual(beyond(49, 176, 775), ['medium'])
  assert.deepEqual(beyond(34, 33, 33), ['high', 'medium', 'low'])
  assert.deepEqual(beyond(0, 0, 100), [])
})

test('fewer than twenty alarms are not judged', () => {
  assert.deepEqual(beyond(19, 0, 0), [])
  assert.deepEqual(beyond(0, 0, 0), [])
  assert.deepEqual(beyond(20, 0, 0), ['high', 'low'])
})
