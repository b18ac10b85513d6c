import assert from 'node:assert/strict'
import { test } from 'node:test'
import { pressureRange } from '../dist/test/lib/pressure-range.js'

const gauge = (readings, age_ms = 0) => ({ age_ms, stale_after_ms: 1000, readings })
const reading = (pa, quality = 'valid', limit_pa = null) => ({ pa, quality, limit_pa })

test('a range has the lowest and the highest pressure, which may be the end of a range', () => {
  const gauges = [
    gauge([reading(1e-5), reading(20)]),
    gauge([reading(null, 'underrange', 1e-6), reading(null, 'off')]),
    gauge([reading(null, 'overrange', 1e4)]),
  ]
  assert.deepEqual(pressureRange(gauges, 0), {
    lowest: { pa: 1e-6, quality: 'underrange' },
    highest: { pa: 1e4, quality: 'overrange' },
  })
})

test('the end below which a gauge cannot measure is the highest pressure only if no gauge measures', () => {
  const bound = gauge([reading(null, 'underrange', 10)])
  assert.deepEqual(pressureRange([bound, gauge([reading(1e-5)])], 0), {
    lowest: { pa: 1e-5, quality: 'valid' },
    highest: { pa: 1e-5, quality: 'valid' },
  })
  assert.deepEqual(pressureRange([bound], 0)?.highest, { pa: 10, quality: 'underrange' })
})

test('readings that are no pressure now are no part of a range', () => {
  const gauges = [gauge([reading(5, 'fault')]), gauge([reading(1e-9)], 600), gauge([reading(3)], 0)]
  assert.deepEqual(pressureRange(gauges, 500), {
    lowest: { pa: 3, quality: 'valid' },
    highest: { pa: 3, quality: 'valid' },
  })
  assert.equal(pressureRange(gauges, 5000), null)
})
