import assert from 'node:assert/strict'
import { test } from 'node:test'
import { csvAddress } from '../dist/test/api/calls.js'
import { quantity, summary } from '../dist/test/lib/alarms.js'
import { moment } from '../dist/test/lib/format.js'
import { gatewayState, gatewayTitle } from '../dist/test/lib/gateways.js'
import { baud, changeText, gas, lostSentence, segmentSentence } from '../dist/test/lib/labels.js'
import { boundsText } from '../dist/test/lib/plant.js'
import { usualness } from '../dist/test/lib/pump-downs.js'
import {
  aligned,
  fittingRange,
  fittingSpan,
  moved,
  rangeOf,
  rangeText,
  SEARCH_MS,
  tableTimes,
  toggled,
  windowOf,
  zoomed,
} from '../dist/test/lib/range.js'
import { fitted, scaleFrom, verdict } from '../dist/test/lib/rise.js'
import { matchingBlocks } from '../dist/test/lib/search.js'
import { ageOf, currentQuality, isStale } from '../dist/test/lib/stale.js'

const gauge = { age_ms: 100, stale_after_ms: 3_000 }

test('a reading becomes stale when no new one arrives', () => {
  assert.equal(ageOf(gauge, 500), 600)
  assert.equal(ageOf({ age_ms: null }, 500), null)
  assert.ok(!isStale(gauge, 2_800) && isStale(gauge, 3_000))
  assert.ok(isStale({ age_ms: null, stale_after_ms: 3_000 }, 0))
})

test('the station decides after which time a reading is stale', () => {
  assert.ok(!isStale({ age_ms: 60_000, stale_after_ms: 18_000_000 }, 0))
})

test('a reading that is too old is stale, whatever its quality was', () => {
  assert.equal(currentQuality(gauge, { quality: 'overrange' }, 0), 'overrange')
  assert.equal(currentQuality(gauge, { quality: 'valid' }, 10_000), 'stale')
})

test('pixels do not move with the time', () => {
  const one = aligned([1_000_000, 1_600_000], 1000)
  const other = aligned([1_000_300, 1_600_300], 1000)
  assert.equal(one.binMs, 600)
  assert.equal((other.from - one.from) % 600, 0)
  assert.equal(one.to - one.from, one.count * one.binMs)
  assert.ok(one.from <= 910_000 && one.to >= 1_690_000)
})

test('no request has more pixels than the station accepts', () => {
  for (const span of [2_000, 60_000, 3_600_000, 86_400_000, 31_536_000_000]) {
    assert.ok(aligned([0, span], 3000).count <= 20_000, String(span))
  }
})

test('zooming keeps the time under the cursor in its place', () => {
  const { from, to } = zoomed([0, 100_000], 25_000, 0.5)
  assert.deepEqual([from, to], [12_500, 62_500])
  assert.equal((25_000 - from) / (to - from), 0.25)
  assert.deepEqual(moved([0, 100], 0.5), { from: 50, to: 150 })
})

test('a data table has round times within the window, the latest first', () => {
  const minute = 60_000
  assert.deepEqual(tableTimes([30_500, 3 * minute + 1], 4), [3 * minute, 2 * minute, minute])
  assert.deepEqual(tableTimes([0, 10_000], 30).slice(0, 2), [10_000, 9_000])
  for (const span of [2_000, 60_000, 3_600_000, 86_400_000, 31_536_000_000]) {
    const times = tableTimes([1, 1 + span], 30)
    assert.ok(times.length > 0 && times.length <= 30, `${span}: ${times.length}`)
  }
})

test('the address of the page holds the range', () => {
  for (const range of [{ last: 600_000 }, { from: 1_000, to: 9_000 }]) {
    assert.deepEqual(rangeOf(new URLSearchParams(rangeText(range))), range)
  }
  for (const wrong of ['', 'range=never', 'from=x&to=5', 'from=9&to=5']) {
    assert.deepEqual(rangeOf(new URLSearchParams(wrong)), { last: 3_600_000 }, wrong)
  }
  assert.deepEqual(windowOf({ last: 10 }, 100), [90, 100])
})

test('a live chart is held where it is, and a held one goes on with a span that is as long', () => {
  assert.deepEqual(toggled({ last: 60_000 }, 100_000), { from: 40_000, to: 100_000 })
  assert.deepEqual(toggled({ from: 40_000, to: 100_000 }, 500_000), { last: 60_000 })
  assert.deepEqual(toggled({ from: 0, to: 61_000 }, 500_000), { last: 600_000 })
  assert.deepEqual(toggled({ from: 0, to: 1e12 }, 2e12), { last: 604_800_000 })
})

test('a recording that has just begun fills the chart', () => {
  const now = 10_000_000
  const ages = [0, 7_000, 45_000, 75_000, 300_000, 3_000_000]
  const spans = ages.map((age) => fittingRange(now - age, now).last)
  assert.deepEqual(spans, [20_000, 20_000, 60_000, 120_000, 600_000, 3_600_000])
  assert.deepEqual(fittingRange(null, now), { last: 20_000 })
  // Nothing that was recorded leaves the chart before the beginning is searched again.
  for (const [index, age] of ages.entries()) assert.ok(spans[index] >= age + SEARCH_MS)
  assert.equal(fittingSpan(now - 900_000, now, 600_000), 600_000)
})

test('a run without a deviation is as usual only if it was compared', () => {
  assert.equal(usualness({ levels: [{ pa: 1, s: 3, usual: null }] }), 'not compared')
  assert.equal(usualness({ levels: [{ pa: 1, s: 3, usual: { s: 3, least_s: 2, most_s: 4, runs: 5 } }] }), 'as usual')
})

test('the scale of a rise is not that of the pump-down before it', () => {
  const [times, means] = [
    [0, 10, 20, 30, 40],
    [1000, 1, 1e-6, 2e-6, 3e-6],
  ]
  assert.equal(scaleFrom(times, means, [0, 40], null), 20)
  assert.equal(scaleFrom(times, means, [25, 40], null), 30)
  assert.equal(scaleFrom(times, means, [0, 40], 15), 15, 'from the beginning of the measurement')
  assert.equal(scaleFrom([0, 10], [1000, 1], [0, 10], null), 9, 'the pressure falls')
  assert.equal(scaleFrom([], [], [0, 10], null), 0)
})

test('the audit trail names states of alarms as the other pages, and values as they are', () => {
  const changed = (before, after, action = 'outcome') => changeText({ action, before, after })
  assert.equal(changed('unacknowledged', 'out-of-service'), 'not acknowledged → out of service')
  assert.equal(changed('5 Pa', null), '5 Pa → unknown')
  const utc = '2026-11-28T18:52:58Z'
  assert.equal(changed(null, `declared until ${utc}`), `declared until ${moment(Date.parse(utc))}`)
  assert.equal(changed(null, 'toString'), 'toString')
  assert.equal(changed(null, null), '')
})

test('a key that comes into the station’s file or leaves it says so in the audit trail', () => {
  const changed = (before, after) => changeText({ action: 'file-changed', before, after })
  assert.equal(changed('0.2', null), '0.2 → not in the file')
  assert.equal(changed(null, '0.2'), 'not in the file → 0.2')
  assert.equal(changed('0.2', '0.3'), '0.2 → 0.3')
  assert.equal(changed('normal', 'shelved'), 'normal → shelved', 'a value of the file, not a state')
  assert.equal(changed(null, null), '', 'the number of further keys')
})

test('a number of gauges in an alarm has words, and one gauge its singular', () => {
  assert.equal(quantity(3, 'gauges', 'mbar'), '3\u00a0gauges')
  assert.equal(quantity(1, 'gauges', 'mbar'), '1\u00a0gauge')
})

test('a number that cannot be told from zero is its upper bound', () => {
  assert.deepEqual(boundsText({ mean: 0, low: 0, high: 2e-3 }, 1e-3).value, '< 2.00')
  assert.deepEqual(boundsText({ mean: 0, low: 0, high: null }, 1).value, '0')
  assert.deepEqual(boundsText({ mean: 1, low: 0, high: 2 }, 1).value, '1.00')
})

test('alarms that have cleared have the priority of the most urgent one', () => {
  const none = { active: 0, unacknowledged: 0 }
  const { active, unacknowledgedCounts } = summary({
    high: none,
    medium: { ...none, unacknowledged: 2 },
    low: none,
  })
  assert.deepEqual([active, unacknowledgedCounts[0].priority], [[], 'medium'])
})

const rise = {
  cause: 'both',
  misfit: 1,
  fitted: [
    { s: 0, pa: 1 },
    { s: 10, pa: 3 },
  ],
}

test('the fit of a rise is drawn between its points only', () => {
  assert.equal(fitted(rise, 0), 1)
  assert.equal(fitted(rise, 5), 2)
  assert.equal(fitted(rise, 10), 3)
  assert.equal(fitted(rise, -1), null)
  assert.equal(fitted(rise, 11), null)
  assert.equal(fitted({ ...rise, fitted: [] }, 0), null)
})

test('the cause of a rise is said in words', () => {
  const title = (change) => verdict({ ...rise, ...change }).title
  assert.equal(title({}), 'A leak and outgassing')
  assert.equal(title({ cause: 'leak' }), 'A leak')
  assert.equal(title({ cause: 'outgassing' }), 'Outgassing')
  assert.equal(title({ cause: 'undistinguished' }), 'Leak and outgassing cannot be distinguished')
  assert.equal(title({ cause: 'no-rise', misfit: 9 }), 'No rise')
  assert.equal(title({ misfit: 4 }), 'The fit does not match the curve')
})

test('parameters are found by any of their words', () => {
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
  assert.deepEqual(matchingBlocks(blocks, ''), [blocks[0]])
  assert.deepEqual(matchingBlocks(blocks, 'pa HIGH'), [blocks[0]])
  assert.deepEqual(matchingBlocks(blocks, 'low'), [])
})

test('the state of a segment is a sentence', () => {
  const segment = {
    state: 'running',
    problem: null,
    stations: [{ address: 3, state: 'data-exchange', description: 'fine' }],
  }
  assert.equal(segmentSentence(segment), 'All gauges exchange data.')
  assert.equal(segmentSentence({ ...segment, problem: 'the port is lost' }), 'Not working: the port is lost.')
  assert.equal(segmentSentence({ ...segment, state: 'waiting' }), 'The segment is waiting for the port.')
  const missing = { address: 7, state: 'missing', name: 'gate', description: 'no answer' }
  assert.equal(segmentSentence({ ...segment, stations: [missing] }), 'gate: no answer.')
  const all = ['a', 'b', 'c', 'd', 'e'].map((name) => ({ ...missing, name }))
  assert.equal(
    segmentSentence({ ...segment, stations: all }),
    'a: no answer; b: no answer; c: no answer; and 2 more.',
    'a segment that is off does not fill the page',
  )
})

test('texts for gases and baud rates', () => {
  assert.deepEqual(['n2', 'Ar', 'he', 'CO2'].map(gas), ['N₂', 'Ar', 'He', 'CO₂'])
  assert.deepEqual([19_200, 93_750, 1_500_000].map(baud), ['19.2 kbit/s', '93.75 kbit/s', '1.5 Mbit/s'])
})

test('lost samples and events are counted in a sentence', () => {
  const sentence = (lost_samples, lost_events) =>
    lostSentence({ last_write_ms: 1, error: null, lost_samples, lost_events, last_check_ms: null, damage: null })
  assert.equal(sentence(0, 0), null)
  assert.equal(sentence(7, 0), '7 samples could not be recorded.')
  assert.equal(sentence(0, 1), '1 event could not be recorded.')
  assert.equal(sentence(1, 20), '1 sample and 20 events could not be recorded.')
})

test('an export repeats the parameter for each series', () => {
  assert.equal(
    csvAddress(['hall, north', 'annex'], 1, 2),
    '/api/export.csv?from=1&to=2&series=hall%2C+north&series=annex',
  )
})

test('a gateway that does not run shows why', () => {
  assert.equal(gatewayState({ is_running: true, problem: null }), 'running')
  assert.equal(gatewayState({ is_running: false, problem: null }), 'starting')
  const problem = 'cannot listen on 127.0.0.1:9464'
  assert.equal(gatewayState({ is_running: false, problem }), `does not run, tries again: ${problem}`)
})

test('a gateway has the name of its protocol, and an unknown one its own', () => {
  assert.deepEqual(['opcua', 'modbus', 'other'].map(gatewayTitle), ['OPC UA', 'Modbus TCP', 'other'])
})
