// The points of a slave as the dashboard shows them.

import assert from 'node:assert/strict'
import { test } from 'node:test'
import { snapshotOf } from '../dist/test/lib/merge.js'
import { pointCause, pointText, slaveValue } from '../dist/test/lib/points.js'

const point = (text, quality = 'valid') => ({
  target: 'speed',
  name: 'slot 1',
  unit: 'Hz',
  number: 1000,
  text,
  quality,
})

test('a point has its text with the unit, and none once it is stale', () => {
  assert.equal(pointText(point('1000 Hz'), false), '1000 Hz')
  assert.equal(pointText(point('1000 Hz'), true), null)
  assert.equal(pointText(point('', 'stale'), false), null)
})

test('a point whose record was not read says why', () => {
  assert.equal(pointCause(point('record 1/24 was not read: no answer', 'stale')), 'record 1/24 was not read: no answer')
  assert.equal(pointCause(point('', 'stale')), null)
  assert.equal(pointCause(point('1000 Hz')), null)
})

test('a point whose number is bad says why', () => {
  assert.equal(pointText(point('bad, status 00h', 'fault'), false), 'bad, status 00h')
})

test('the wall shows the first point of a slave with its name, its fault, or that it gives no data', () => {
  const slave = (state, quality = 'valid') => ({ state, parameters: [point('1000 Hz', quality), point('2')] })
  assert.deepEqual(slaveValue(slave('data-exchange'), false), { point: 'speed', text: '1000 Hz', isFault: false })
  assert.deepEqual(slaveValue(slave('fault'), false), { point: '', text: '1000 Hz', isFault: true })
  assert.deepEqual(slaveValue(slave('fault'), true), { point: '', text: null, isFault: false })
  assert.deepEqual(slaveValue(slave('missing', 'stale'), false), { point: '', text: null, isFault: false })
  assert.deepEqual(slaveValue({ state: 'data-exchange', parameters: [] }, false), {
    point: '',
    text: null,
    isFault: false,
  })
})

test('the points of a slave keep the order of the file through the live stream', () => {
  const points = ['speed', 'current', 'ready'].map((target) => ({ ...point('1'), target }))
  const state = {
    gauges: { turbo: { name: 'turbo', kind: 'slave', readings: [], parameters: points } },
    gauge_order: ['turbo'],
    segments: {},
    alarms: {},
    standing_alarms: {},
    plant: { states: {} },
  }
  assert.deepEqual(
    snapshotOf(state).gauges[0].parameters.map(({ target }) => target),
    ['speed', 'current', 'ready'],
  )
})
