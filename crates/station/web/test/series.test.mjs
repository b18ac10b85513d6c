import assert from 'node:assert/strict'
import { test } from 'node:test'
import {
  bits,
  decades,
  FAULT,
  GAP,
  indexAt,
  join,
  OVER,
  qualityOf,
  sampleAt,
  stretches,
  UNDER,
  valuesOf,
  withoutData,
  withRecent,
} from '../dist/test/lib/series.js'

const VALID = 1

/** A trend of [time in s, pressure or null, qualities]. */
function trend(...entries) {
  const values = entries.map(([, pa]) => pa)
  return {
    series: 'a',
    start_ms: entries.map(([second]) => second * 1000),
    low: values.map((pa) => pa && pa / 2),
    high: values.map((pa) => pa && pa * 2),
    mean: values,
    last: values.map(() => null),
    qualities: entries.map(([, , quality = VALID]) => quality),
  }
}

test('curves share their times, and a line goes through the times of others', () => {
  const { times, curves } = join([trend([0, 1], [60, 2]), trend([30, 5])], 1000)
  assert.deepEqual(times, [0, 30_000, 60_000])
  assert.deepEqual([...curves[0].mean], [1, undefined, 2])
  assert.deepEqual([...curves[0].low], [0.5, undefined, 1])
  assert.deepEqual([...curves[1].mean], [undefined, 5, undefined])
})

test('a gap reaches over the times of other curves', () => {
  const gappy = trend([0, 1], [20, null, GAP], [40, 2])
  const { curves } = join([gappy, trend([10, 7], [30, 7])], 1000)
  assert.deepEqual([...curves[0].mean], [1, null, null, null, 2])
  assert.deepEqual([...curves[0].high], [2, null, null, null, 4])
})

test('a gap that begins in the pixel of a value ends the line there', () => {
  const { times, curves } = join([trend([0, 1], [1, 1, VALID | GAP], [30, 2])], 1000)
  assert.deepEqual(times, [0, 1000, 2000, 30_000])
  assert.deepEqual([...curves[0].mean], [1, 1, null, 2])
})

test('a gap that ended within its pixel does not break the line', () => {
  const { curves } = join([trend([0, 1], [1, 1, VALID | GAP], [2, 2])], 1000)
  assert.deepEqual([...curves[0].mean], [1, 1, 2])
})

test('a long time without samples is a gap without a mark', () => {
  assert.deepEqual([...join([trend([0, 1], [100, 2])], 1000).curves[0].mean], [1, 2])
  assert.deepEqual([...join([trend([0, 1], [200, 2])], 1000).curves[0].mean], [1, null, 2])
  // Pixels that are themselves longer are neighbours.
  assert.deepEqual([...join([trend([0, 1], [200, 2])], 200_000).curves[0].mean], [1, 2])
})

test('a stretch outside the range reaches from its first to its last sample', () => {
  const over = trend([0, 1], [10, 5, OVER], [20, 5, VALID | OVER], [30, 1], [40, null, 8])
  assert.deepEqual(stretches(over, 1000), [
    { from: 10_000, to: 30_000, kind: 'over', limit: 10 },
    { from: 40_000, to: 41_000, kind: 'fault', limit: null },
  ])
})

test('no line is drawn outside the range', () => {
  const { curves } = join([trend([0, 1], [10, 5, OVER], [20, 5, VALID | OVER])], 1000)
  assert.deepEqual([...curves[0].mean], [1, null, 5])
})

/** A trend of single samples: each pixel ends with its value. */
function sampled(...entries) {
  const made = trend(...entries)
  return { ...made, low: made.mean, high: made.mean, last: made.mean }
}

/** The points of a curve: [time in ms, value]. */
function points({ times, curves }) {
  return times.flatMap((time, index) => (curves[0].mean[index] === undefined ? [] : [[time, curves[0].mean[index]]]))
}

test('a held value is drawn as held until it jumps', () => {
  // One sample a minute while nothing changes; the pixel of the jump has the mean of the values before and after it.
  const jump = sampled([0, 1], [59, 4], [60, 4])
  jump.mean = [1, 2, 4]
  assert.deepEqual(points(join([jump], 1000)), [
    [0, 1],
    [58_999, 1],
    [59_000, 2],
    [60_000, 4],
  ])
  // The value behind a jump is held too.
  const held = sampled([0, 4], [60, 4])
  held.mean = [2, 4]
  assert.deepEqual(points(join([held], 1000)), [
    [0, 2],
    [1000, 4],
    [60_000, 4],
  ])
})

test('a slow change within the deadband is a straight line', () => {
  assert.deepEqual(points(join([sampled([0, 1], [60, 1.004])], 1000)), [
    [0, 1],
    [60_000, 1.004],
  ])
})

test('a value is held until the gauge leaves its range, and not over a gap', () => {
  assert.deepEqual(points(join([sampled([0, 1], [60, 5, OVER])], 1000)), [
    [0, 1],
    [59_999, 1],
    [60_000, null],
  ])
  assert.deepEqual(points(join([sampled([0, 1], [400, 2])], 1000)), [
    [0, 1],
    [1000, null],
    [400_000, 2],
  ])
})

test('behind its pixel a sample is the last value of the pixel, which ended a gap within it', () => {
  const mixed = { ...trend([0, 2, VALID | OVER | GAP], [60, 4]), low: [1, 4], high: [9, 4], last: [4, 4] }
  assert.deepEqual(sampleAt(mixed, 500, 1000), { mean: 9, bits: VALID | OVER | GAP })
  assert.deepEqual(sampleAt(mixed, 30_000, 1000), { mean: 4, bits: VALID })
  assert.deepEqual(withoutData(mixed, 1000, [0, 60_000]), [])
  assert.deepEqual(stretches(mixed, 1000), [{ from: 0, to: 1000, kind: 'over', limit: 9 }])
  assert.deepEqual(points(join([mixed], 1000)), [
    [0, 2],
    [1000, 4],
    [60_000, 4],
  ])
})

test('no line is drawn from the pixel in which the gauge left its range to the next value', () => {
  const left = { ...trend([0, 1], [60, 3, VALID | OVER], [120, 1]), last: [1, null, 1] }
  const { times, curves } = join([left], 1000)
  assert.deepEqual(times.slice(-3), [60_000, 61_000, 120_000])
  assert.deepEqual([...curves[0].mean].slice(-3), [3, null, 1])
  // Summaries alone do not tell how a pixel ended.
  assert.deepEqual([...join([{ ...left, last: [null, null, null] }], 1000).curves[0].mean], [1, 3, 1])
})

test('without the last values of the pixels nothing is held', () => {
  assert.deepEqual(points(join([trend([0, 1], [60, 2])], 1000)), [
    [0, 1],
    [60_000, 2],
  ])
})

test('beyond the range a sample is the end of the range, and it is a value of the chart', () => {
  const beyond = { ...trend([0, null, OVER], [10, 1, VALID | UNDER]), low: [9, 0.1], high: [9, 3] }
  assert.deepEqual(sampleAt(beyond, 0, 1000), { mean: 9, bits: OVER })
  assert.deepEqual(sampleAt(beyond, 10_000, 1000), { mean: 0.1, bits: VALID | UNDER })
  assert.deepEqual(valuesOf(beyond), [null, 9, 1, 0.1])
})

test('a stretch ends where a gap begins in its pixel', () => {
  const ended = trend([0, null, FAULT], [1, null, FAULT | GAP], [30, null, FAULT], [31, 1])
  assert.deepEqual(
    [...stretches(ended, 1000), ...withoutData(ended, 1000, [0, 31_000])].map(({ from, to, kind }) => [from, to, kind]),
    [
      [0, 2000, 'fault'],
      [30_000, 31_000, 'fault'],
      [2000, 30_000, 'none'],
    ],
  )
})

test('a stretch does not reach over a long time without samples', () => {
  const distant = trend([0, 1, UNDER], [1000, 1])
  assert.deepEqual(stretches(distant, 1000), [{ from: 0, to: 1000, kind: 'under', limit: 0.5 }])
  const none = { from: 1000, to: 1_000_000, kind: 'none', limit: null }
  assert.deepEqual(withoutData(distant, 1000, [0, 1_000_000]), [none])
})

test('times without data are one stretch each, before the first sample and behind the last one too', () => {
  const none = (trend, window) => withoutData(trend, 600, window).map(({ from, to }) => [from, to])
  // The gauge was lost at 10 s: since then the live stream says so every second.
  const lost = Array.from({ length: 300 }, (_, second) => ({ at: 10_000 + 1000 * second, pa: null, bits: GAP }))
  assert.deepEqual(none(withRecent(trend([0, 1], [9, 1]), lost), [0, 310_000]), [[10_000, 310_000]])
  assert.deepEqual(none(trend([0, 1], [1, 1, VALID | GAP]), [0, 60_000]), [[1600, 60_000]])
  assert.deepEqual(none(trend([0, 1]), [0, 400_000]), [[600, 400_000]])
  assert.deepEqual(none(trend([400, 1]), [0, 400_000]), [[0, 400_000]])
  assert.deepEqual(none(trend(), [0, 400_000]), [[0, 400_000]])
  assert.deepEqual(none(trend([60, 1], [100, 1]), [0, 160_000]), [], 'a sample is at most a minute later')
})

test('recent samples are added, and none twice', () => {
  const recent = [
    { at: 1000, pa: 9, bits: VALID },
    { at: 2000, pa: 3, bits: VALID },
    { at: 3000, pa: null, bits: GAP },
  ]
  const added = withRecent(trend([0, 1], [1, 2]), recent)
  assert.deepEqual(added.start_ms, [0, 1000, 2000, 3000])
  assert.deepEqual(added.mean, [1, 2, 3, null])
  assert.deepEqual(withRecent(trend(), recent).mean, [9, 3, null])
})

test('a sample holds until the next one, and not in a gap', () => {
  const one = trend([0, 1], [60, 2, VALID | GAP], [120, 3])
  assert.deepEqual(sampleAt(one, 59_000, 1000), { mean: 1, bits: VALID })
  assert.deepEqual(sampleAt(one, 60_500, 1000), { mean: 2, bits: VALID | GAP })
  assert.deepEqual(sampleAt(one, 90_000, 1000), { mean: null, bits: GAP })
  assert.equal(sampleAt(one, -1, 1000), null)
  assert.equal(sampleAt(one, 1_000_000, 1000), null)
})

test('the index of a time is found', () => {
  assert.deepEqual(
    [-1, 0, 5, 10, 99].map((at) => indexAt([0, 10, 20], at)),
    [-1, 0, 0, 1, 2],
  )
  assert.equal(indexAt([], 5), -1)
})

test('an axis has whole decades, at least two', () => {
  assert.deepEqual(decades(3e-7, 2e-3), [1e-7, 1e-2])
  assert.deepEqual(decades(2, 3), [0.1, 10])
  assert.deepEqual(decades(Infinity, -Infinity), [1e-3, 1e3])
})

test('the quality of a sample is the worst that applies to its mean', () => {
  assert.equal(qualityOf({ mean: 1, bits: VALID | GAP }), 'valid')
  assert.equal(qualityOf({ mean: 1, bits: VALID | OVER }), 'overrange')
  assert.equal(qualityOf({ mean: null, bits: 8 }), 'fault')
  assert.equal(qualityOf({ mean: null, bits: GAP }), 'stale')
  assert.deepEqual(
    [32, 64, 128].map((bits) => qualityOf({ mean: null, bits })),
    ['off', 'missing', 'assumed'],
  )
})

test('qualities are the bits of the API', () => {
  assert.deepEqual(
    ['valid', 'overrange', 'underrange', 'fault', 'stale', 'off', 'missing', 'assumed'].map(bits),
    [1, 2, 4, 8, 16, 32, 64, 128],
  )
})
