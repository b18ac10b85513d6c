import assert from 'node:assert/strict'
import { test } from 'node:test'
import { differenceOf, differenceText, slopeText } from '../dist/test/lib/difference.js'
import { eventGroups } from '../dist/test/lib/event-lane.js'
import { UNDER } from '../dist/test/lib/series.js'

const sample = (mean, bits = 1) => ({ mean, bits })

test('a sample is compared with the reference by ratio, difference and slope', () => {
  const { ratio, difference, slope } = differenceOf(sample(1e-4), sample(1e-5), 60_000)
  assert.ok(Math.abs(ratio - 0.1) < 1e-12)
  assert.ok(Math.abs(difference + 9e-5) < 1e-15)
  assert.ok(Math.abs(slope * 60_000 + 1) < 1e-12, 'a decade less in a minute')
})

test('a sample before the reference has the slope of the time between them', () => {
  assert.ok(
    differenceOf(sample(1e-5), sample(1e-4), -60_000).slope < 0,
    'the pressure falls from the sample to the reference',
  )
})

test('at the reference itself there is no slope', () => {
  assert.deepEqual(differenceOf(sample(2), sample(2), 0), { ratio: 1, difference: 0, slope: null })
})

test('the end of a range, a gap and a missing sample are not compared', () => {
  assert.equal(differenceOf(sample(1e-4), sample(5e-5, UNDER), 1), null)
  assert.equal(differenceOf(sample(null), sample(1), 1), null)
  assert.equal(differenceOf(null, sample(1), 1), null)
  assert.equal(differenceOf(sample(1), null, 1), null)
})

test('a difference is a text in the unit of the display', () => {
  assert.equal(
    differenceText({ ratio: 0.25, difference: -3.75e-5, slope: -1e-5 }, 'mbar'),
    '× 0.25, −3.75 × 10⁻⁷ mbar, −0.6 decades/min',
  )
  assert.equal(differenceText({ ratio: 1, difference: 0, slope: null }, 'Pa'), '× 1, 0 Pa')
})

test('a slope has the unit in which it is read easily', () => {
  assert.equal(slopeText(-0.5 / 1_000), '−0.5 decades/s')
  assert.equal(slopeText(0.2 / 60_000), '+0.2 decades/min')
  assert.equal(slopeText(0.011 / 86_400_000), '+0.011 decades/d')
  assert.equal(slopeText(0), '0 decades/d')
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
