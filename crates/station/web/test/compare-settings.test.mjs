import assert from 'node:assert/strict'
import { test } from 'node:test'
import { compared } from '../dist/test/lib/compare-settings.js'

const write = { role: 'engineer' }
const parameter = (target, value, more = {}) => ({ target, value, write, ...more })
const block = (...parameters) => [{ name: 'block', parameters }]

test('settings that both gauges have given are compared, and those that differ have both values', () => {
  const own = block(
    parameter('trip', '1e-3 mbar'),
    parameter('mode', 'hold'),
    parameter('pressure', '2e-3 mbar', { write: null }),
    parameter('silent', null),
    parameter('only here', 'yes'),
  )
  const other = block(
    parameter('mode', 'zero'),
    parameter('trip', '1e-3 mbar'),
    parameter('pressure', '5e-7 mbar'),
    parameter('silent', 'on'),
  )
  const found = compared(own, other)
  assert.equal(found.compared, 2)
  assert.deepEqual(
    found.differences.map(({ parameter, other }) => [parameter.target, parameter.value, other]),
    [['mode', 'hold', 'zero']],
  )
})

test('a pressure is the same in every unit, and a unit alone is no pressure', () => {
  const differs = (one, other) => compared(block(parameter('a', one)), block(parameter('a', other))).differences.length
  assert.equal(differs('1 mbar', '100 Pa'), 0)
  assert.equal(differs('1 mbar', '101 Pa'), 1)
  assert.equal(differs('mbar', 'Pa'), 1)
  assert.equal(differs('0 mbar', '0 Torr'), 0)
})
