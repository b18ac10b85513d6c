import assert from 'node:assert/strict'
import { test } from 'node:test'
import { aligned, moved, rangeOf, rangeText, windowOf, zoomed } from '../dist/test/pure/range.js'
import { fitted, steadyPart, verdict } from '../dist/test/pure/rise.js'
import { matching } from '../dist/test/pure/search.js'
import { ageOf, isStale, worth } from '../dist/test/pure/stale.js'
import { exportAddress } from '../dist/test/api.js'
import { baud, gas, lostSentence, segmentSentence } from '../dist/test/pure/words.js'

const gauge = { age_ms: 100, poll_ms: 200 }

test('a reading becomes stale with the time nothing comes', () => {
  assert.equal(ageOf(gauge, 500), 600)
  assert.equal(ageOf({ age_ms: null }, 500), null)
  assert.ok(!isStale(gauge, 2_800) && isStale(gauge, 3_000))
  assert.ok(isStale({ age_ms: null, poll_ms: 200 }, 0))
})

test('a gauge that is asked once an hour is not stale after a minute', () => {
  assert.ok(!isStale({ age_ms: 60_000, poll_ms: 3_600_000 }, 0))
})

test('what is stale is worth nothing, whatever it was', () => {
  assert.equal(worth(gauge, { quality: 'overrange' }, 0), 'overrange')
  assert.equal(worth(gauge, { quality: 'valid' }, 10_000), 'gap')
})

test('pixels stay where they are while time goes on', () => {
  const one = aligned([1_000_000, 1_600_000], 1000)
  const other = aligned([1_000_300, 1_600_300], 1000)
  assert.equal(one.binMs, 600)
  assert.equal((other.from - one.from) % 600, 0)
  assert.equal(one.to - one.from, one.count * one.binMs)
  assert.ok(one.from <= 910_000 && one.to >= 1_690_000)
})

test('the station is never asked for more pixels than it draws', () => {
  for (const span of [2_000, 60_000, 3_600_000, 86_400_000, 31_536_000_000]) {
    assert.ok(aligned([0, span], 3000).count <= 20_000, String(span))
  }
})

test('zooming leaves what is under the cursor where it is', () => {
  const { from, to } = zoomed([0, 100_000], 25_000, 0.5)
  assert.deepEqual([from, to], [12_500, 62_500])
  assert.equal((25_000 - from) / (to - from), 0.25)
  assert.deepEqual(moved([0, 100], 0.5), { from: 50, to: 150 })
})

test('a range stands in the address of the page', () => {
  for (const range of [{ last: 600_000 }, { from: 1_000, to: 9_000 }]) {
    assert.deepEqual(rangeOf(new URLSearchParams(rangeText(range))), range)
  }
  for (const wrong of ['', 'range=never', 'from=x&to=5', 'from=9&to=5']) {
    assert.deepEqual(rangeOf(new URLSearchParams(wrong)), { last: 3_600_000 }, wrong)
  }
  assert.deepEqual(windowOf({ last: 10 }, 100), [90, 100])
})

const rise = { start_pa: 1, steady_pa_per_s: 0.1, bend_pa: 10, tau_s: 100, explained: 0.999, samples: 100 }

test('a fitted rise begins where it begins and bends with its time constant', () => {
  assert.equal(fitted(rise, 0), 1)
  assert.ok(Math.abs(fitted(rise, 100) - (1 + 10 + 10 * (1 - Math.exp(-1)))) < 1e-9)
  assert.equal(fitted({ ...rise, bend_pa: null, tau_s: null }, 10), 2)
})

test('what a rise means is said in words', () => {
  assert.equal(steadyPart(rise), 0.5)
  const title = (change) => verdict({ ...rise, ...change }).title
  assert.equal(title({}), 'Mostly a leak, and some outgassing')
  assert.equal(title({ bend_pa: 50 }), 'Mostly outgassing, and a leak')
  assert.equal(title({ steady_pa_per_s: 0.001 }), 'The curve flattens: outgassing')
  assert.equal(title({ bend_pa: null, tau_s: null }), 'A straight line: a leak')
  assert.equal(title({ bend_pa: null, tau_s: null, steady_pa_per_s: -1 }), 'No rise')
  assert.equal(title({ explained: 0.5 }), 'The curve fits badly')
})

test('outgassing without a leak is not called no rise', () => {
  assert.equal(verdict({ ...rise, steady_pa_per_s: 0 }).title, 'The curve flattens: outgassing')
})

test('parameters are found by any word', () => {
  const parameter = {
    target: 'a/high-trip',
    name: 'High Trip Point',
    numbers: 'slot 1',
    access: 'R',
    value: '5 Pa',
    refusal: null,
  }
  const blocks = [
    { name: 'Trip', parameters: [parameter] },
    { name: 'Empty', parameters: [] },
  ]
  assert.deepEqual(matching(blocks, ''), [blocks[0]])
  assert.deepEqual(matching(blocks, 'pa HIGH'), [blocks[0]])
  assert.deepEqual(matching(blocks, 'low'), [])
})

test('a segment is described in a sentence', () => {
  const segment = { state: 'running', trouble: null, stations: [{ address: 3, standing: 'exchanging', words: 'fine' }] }
  assert.equal(segmentSentence(segment), 'All gauges exchange data.')
  assert.equal(segmentSentence({ ...segment, trouble: 'the port is lost' }), 'In trouble: the port is lost.')
  assert.equal(segmentSentence({ ...segment, state: 'waiting' }), 'The segment waits for its port.')
  const missing = { address: 7, standing: 'missing', name: 'gate', words: 'nobody answers' }
  assert.equal(segmentSentence({ ...segment, stations: [missing] }), 'gate: nobody answers.')
})

test('words for gases and rates', () => {
  assert.deepEqual(['n2', 'Ar', 'he', 'CO2'].map(gas), ['N₂', 'Ar', 'He', 'CO₂'])
  assert.deepEqual([19_200, 93_750, 1_500_000].map(baud), ['19.2 kbit/s', '93.75 kbit/s', '1.5 Mbit/s'])
})

test('what could not be recorded is told, samples and events', () => {
  const sentence = (lost, lost_events) => lostSentence({ written_ms: 1, error: null, lost, lost_events })
  assert.equal(sentence(0, 0), null)
  assert.equal(sentence(7, 0), '7 samples could not be recorded.')
  assert.equal(sentence(0, 1), '1 event could not be recorded.')
  assert.equal(sentence(1, 20), '1 sample and 20 events could not be recorded.')
})

test('an export names each series by itself', () => {
  assert.equal(
    exportAddress(['hall, north', 'annex'], 1, 2),
    '/api/export.csv?from=1&to=2&series=hall%2C+north&series=annex',
  )
})
