import assert from 'node:assert/strict'
import { test } from 'node:test'
import {
  afterPress,
  HISTORY_COLUMNS,
  historyCsv,
  historyInOrder,
  historyTimes,
  NEWEST_FIRST,
} from '../dist/test/lib/alarm-history.js'
import { moment } from '../dist/test/lib/format.js'

const event = (at_ms, alarm, more = {}) => ({
  ...{ at_ms, alarm, subject: null, priority: 'medium', change: 'raised', state: 'unacknowledged' },
  ...{ user: null, value: null, unit: null, text: null, occurrence: 1 },
  ...more,
})

const EVENTS = [
  event(3, 'b 10', { priority: 'low', user: 'olga', value: 5 }),
  event(2, 'b 9', { priority: 'high' }),
  event(1, 'a', { change: 'acknowledged', user: 'ada', value: 40 }),
]

test('the history is sorted by each column in both directions, and entries without a value are last', () => {
  const order = (column, isDescending) => historyInOrder(EVENTS, { column, isDescending }).map(({ at_ms }) => at_ms)
  const both = HISTORY_COLUMNS.map((column) => [column, [order(column, false), order(column, true)]])
  assert.deepEqual(Object.fromEntries(both), {
    time: [
      [1, 2, 3],
      [3, 2, 1],
    ],
    priority: [
      [2, 1, 3],
      [3, 1, 2],
    ],
    change: [
      [1, 3, 2],
      [3, 2, 1],
    ],
    alarm: [
      [1, 2, 3],
      [3, 2, 1],
    ],
    user: [
      [1, 3, 2],
      [3, 1, 2],
    ],
    value: [
      [3, 1, 2],
      [1, 3, 2],
    ],
  })
})

test('a press on a head sorts by the column, and a second one turns it round', () => {
  const byUser = afterPress(NEWEST_FIRST, 'user')
  assert.deepEqual(byUser, { column: 'user', isDescending: false })
  assert.deepEqual(afterPress(byUser, 'user'), { column: 'user', isDescending: true })
  assert.deepEqual(afterPress(byUser, 'time'), NEWEST_FIRST)
  assert.deepEqual(afterPress(NEWEST_FIRST, 'time'), { column: 'time', isDescending: false })
})

test('the times of the history are the last day, or two typed times of which each may be empty', () => {
  const now = 1_800_000_000_000
  assert.deepEqual(historyTimes('', ['', ''], now), { from: 0, to: null })
  assert.deepEqual(historyTimes('86400000', ['', ''], now), { from: now - 86_400_000, to: null })
  const [from, to] = [now - 5_000, now - 1_000]
  assert.deepEqual(historyTimes('between', [moment(from), moment(to)], now), { from, to })
  assert.deepEqual(historyTimes('between', ['', moment(to)], now), { from: 0, to })
  assert.deepEqual(historyTimes('between', [moment(from), ''], now), { from, to: null })
})

test('the CSV file has times in UTC, quotes in texts doubled, and no formula', () => {
  const [head, line, ...rest] = historyCsv([
    event(Date.parse('2026-01-31T14:03:22.125Z'), '=a "b", c', { user: 'olga', value: 1e-5, unit: 'Pa' }),
  ]).split('\n')
  assert.equal(head, 'time,alarm,subject,priority,change,state,user,value,unit,text,occurrence')
  assert.equal(line, `2026-01-31T14:03:22.125Z,"'=a ""b"", c",,medium,raised,unacknowledged,"olga",0.00001,"Pa",,1`)
  assert.deepEqual(rest, [''])
})
