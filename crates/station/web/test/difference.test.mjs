import assert from 'node:assert/strict'
import { test } from 'node:test'
import { differenceOf, differenceParts, differenceText } from '../dist/test/lib/difference.js'
import { eventGroups } from '../dist/test/lib/event-lane.js'
import { UNDER } from '../dist/test/lib/series.js'

const sample = (mean, bits = 1) => ({ mean, bits })

/** The units of a difference after this time. */
const units = (ms) => differenceParts({ ratio: 0.1, difference: -9, ms }, 'Pa').map(({ unit }) => unit)

test('a sample is compared with the reference by ratio, difference and time', () => {
  const { ratio, difference, ms } = differenceOf(sample(1e-4), sample(1e-5), 60_000)
  assert.ok(Math.abs(ratio - 0.1) < 1e-12)
  assert.ok(Math.abs(difference + 9e-5) < 1e-15)
  assert.equal(ms, 60_000)
})

test('a sample before the reference has the slope of the time between them', () => {
  const earlier = differenceOf(sample(1e-5), sample(1e-4), -60_000)
  const values = differenceParts(earlier, 'Pa').map(({ value }) => value)
  assert.deepEqual(values.slice(2), ['−0.0167', '−1.50 × 10⁻⁶'], 'the pressure falls from the sample to the reference')
})

test('at the reference itself there is no slope', () => {
  assert.deepEqual(units(0), ['', 'Pa'])
})

test('the end of a range, a gap and a missing sample are not compared', () => {
  assert.equal(differenceOf(sample(1e-4), sample(5e-5, UNDER), 1), null)
  assert.equal(differenceOf(sample(null), sample(1), 1), null)
  assert.equal(differenceOf(null, sample(1), 1), null)
  assert.equal(differenceOf(sample(1), null, 1), null)
})

test('a difference is a text in the unit of the display', () => {
  assert.equal(
    differenceText({ ratio: 0.25, difference: -3.75e-5, ms: 150_000 }, 'mbar'),
    '× 0.25, −3.75 × 10⁻⁷ mbar, −0.241 decades/min, −1.50 × 10⁻⁷ mbar/min',
  )
  assert.equal(differenceText({ ratio: 1, difference: 0, ms: 0 }, 'Pa'), '× 1, 0 Pa')
  assert.equal(differenceText({ ratio: 1, difference: 0, ms: 1_000 }, 'Pa'), '× 1, 0 Pa, 0 decades/s, 0 Pa/s')
})

test('the unit of a slope follows from the time alone, so that all curves have the same', () => {
  const slopes = [120_000, 120_001, 7_200_001, -172_800_001].map((ms) => units(ms).slice(2).join(' '))
  assert.deepEqual(slopes, ['decades/s Pa/s', 'decades/min Pa/min', 'decades/h Pa/h', 'decades/d Pa/d'])
})

test('events that are close to each other share a mark, others have their own', () => {
  const events = [900, 100, 110, 119, 130, 2_000].map((at_ms) => ({ at_ms, text: `at ${at_ms}` }))
  const groups = eventGroups(events, [0, 1_000], 1_000, 20)
  assert.deepEqual(
    groups.map(({ at_ms, position, events }) => [at_ms, position, events.length]),
    [
      [100, 0.1, 3],
      [130, 0.13, 1],
      [900, 0.9, 1],
    ],
  )
})
