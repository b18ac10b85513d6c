import assert from 'node:assert/strict'
import { test } from 'node:test'
import { afterHead, headDirection, held, inOrder } from '../dist/test/lib/alarm-order.js'

const alarm = (name, priority, raised_ms, gauge, state = 'unacknowledged') => ({
  name,
  priority,
  raised_ms,
  since_ms: raised_ms,
  gauge,
  segment: null,
  state,
})
const names = (list) => list.map(({ name }) => name).join(' ')

test('alarms are listed by urgency, time, priority, gauge and name', () => {
  const list = [
    alarm('c', 'low', 3, 'b'),
    alarm('a', 'high', 1, 'b', 'acknowledged'),
    alarm('d', 'medium', 2, 'a'),
    alarm('b', 'high', 4, null),
  ]
  const orders = ['urgency', 'newest', 'oldest', 'priority', 'state', 'gauge', 'alarm'].map((order) => [
    order,
    names(inOrder(list, order)),
  ])
  assert.deepEqual(Object.fromEntries(orders), {
    urgency: 'b a d c',
    newest: 'b c d a',
    oldest: 'a d c b',
    priority: 'b a d c',
    state: 'b d c a',
    gauge: 'b d a c',
    alarm: 'a b c d',
  })
  assert.equal(names(list), 'c a d b', 'the given list stays')
})

test('a press on the head of a column sorts by it, a further one turns it round or goes back to the groups', () => {
  const presses = (column) => {
    const first = afterHead('urgency', column)
    const second = afterHead(first, column)
    return [first, second, afterHead(second, column)]
  }
  assert.deepEqual(presses('raised'), ['newest', 'oldest', 'urgency'])
  assert.deepEqual(presses('gauge'), ['gauge', 'urgency', 'gauge'])
  assert.equal(afterHead('newest', 'priority'), 'priority')
  assert.deepEqual(
    ['newest', 'oldest', 'priority'].map((order) => headDirection(order, 'raised')),
    ['descending', 'ascending', null],
  )
})

test('while a user works in the list, no alarm changes its place', () => {
  const [a, b, c] = ['a', 'b', 'c'].map((name) => alarm(name, 'high', 1, null))
  const shown = [a, b, c]
  // The first is acknowledged and belongs below the others, the second has ended, and a new one is more urgent than all.
  const acknowledged = { ...a, state: 'acknowledged' }
  const { list, waiting } = held(shown, [alarm('new', 'high', 9, null), c, acknowledged])
  assert.deepEqual([names(list), waiting], ['a b c', 1])
  assert.deepEqual([list[0], list[1]], [acknowledged, b])
  // Held again, the ended one still has its place, and the new one still waits.
  assert.equal(names(held(list, [alarm('new', 'high', 9, null), c]).list), 'a b c')
})
