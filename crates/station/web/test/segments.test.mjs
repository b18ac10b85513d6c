import assert from 'node:assert/strict'
import { test } from 'node:test'
import { countOf, freeAddresses, problemsFirst } from '../dist/test/lib/segments.js'

const segment = (name, states, more = {}) => ({
  name,
  state: 'running',
  problem: null,
  stations: states.map((state, address) => ({ address, state, name: null, description: state })),
  ...more,
})

test('segments with a problem come first, the others in the order of the file', () => {
  const segments = [
    segment('b', ['own-master', 'data-exchange']),
    segment('a', ['own-master', 'starting']),
    segment('unknown slave', ['unconfigured']),
    segment('waiting', [], { state: 'waiting' }),
    segment('missing', ['data-exchange', 'missing']),
    segment('lost', [], { problem: 'the port is lost' }),
    segment('fault', ['fault']),
  ]
  const names = problemsFirst(segments).map(({ name }) => name)
  assert.deepEqual(names, ['lost', 'missing', 'fault', 'unknown slave', 'waiting', 'b', 'a'])
  assert.equal(segments[0].name, 'b', 'the list of the snapshot stays')
})

test('stations are counted by their status, and the other addresses are free', () => {
  const one = segment('hall', ['own-master', 'data-exchange', 'data-exchange', 'fault'])
  assert.equal(countOf(one.stations, 'data-exchange'), 2)
  assert.equal(countOf(one.stations, 'missing'), 0)
  assert.equal(freeAddresses(one), 123)
})
