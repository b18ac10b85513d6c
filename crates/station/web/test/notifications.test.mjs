import assert from 'node:assert/strict'
import { test } from 'node:test'
import { failingLong } from '../dist/test/lib/notifications.js'

test('a receiver is named when notifications have waited for it for longer than a minute', () => {
  const it = (name, problem, failing_since_ms, waiting = 1) => ({ name, problem, failing_since_ms, waiting })
  const all = [
    it('well', null, null),
    it('restarts', 'refused', 40_000),
    it('down', 'refused', 39_999),
    it('idle', 'refused', 0, 0),
  ]
  assert.deepEqual(
    failingLong(all, 100_000).map(({ name }) => name),
    ['down'],
  )
})
