import assert from 'node:assert/strict'
import { test } from 'node:test'
import { failingLong } from '../dist/test/lib/notifications.js'

test('a notification that fails for longer than a minute is named', () => {
  const it = (name, problem, failing_since_ms) => ({ name, problem, failing_since_ms })
  const all = [it('well', null, null), it('restarts', 'refused', 40_000), it('down', 'refused', 39_999)]
  assert.deepEqual(
    failingLong(all, 100_000).map(({ name }) => name),
    ['down'],
  )
})
