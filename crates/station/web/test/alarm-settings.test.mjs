import assert from 'node:assert/strict'
import { test } from 'node:test'
import { formOf, hasReset, resetOf, watchedPressures } from '../dist/test/lib/alarm-settings.js'
import { pascals } from '../dist/test/lib/units.js'

const reset = (settings) => {
  const found = resetOf(formOf(settings))
  return found && `${Number(found.value.toPrecision(6))} ${found.unit}`
}

test('a text is a pressure as in the file of the station', () => {
  for (const [text, pa] of [
    ['1e-3 mbar', 0.1],
    ['1013.25mbar', 101_325],
    [' 2 hpa ', 200],
    ['3 kPa', 3e3],
    ['1 bar', 1e5],
    ['760 Torr', 101_325],
    ['760 MTORR', 101.325],
    ['760e3 micron', 101_325],
    ['5.e-6 mbar', 5e-4],
    ['+.5 Pa', 0.5],
    ['0 Pa', 0],
  ])
    assert.ok(Math.abs(pascals(text) - pa) <= 1e-12 * pa, text)
  for (const wrong of [
    '',
    'mbar',
    '-1 mbar',
    '1e400 mbar',
    'nan mbar',
    '1e-3.2 mbar',
    '1e-3',
    '1 psi',
    '1 m bar',
    '0x1 Pa',
  ])
    assert.equal(pascals(wrong), null, wrong)
})

test('an alarm about a pressure ends at its limit with the hysteresis, or at its reset value', () => {
  assert.equal(reset({ above: '10 mbar' }), '794.328 Pa')
  assert.equal(reset({ below: '10 mbar' }), '1258.93 Pa')
  assert.equal(reset({ above: '10 mbar', hysteresis: 1 }), '100 Pa')
  assert.equal(reset({ below: '10 mbar', hysteresis: 0 }), '1000 Pa')
  assert.equal(reset({ above: '10 mbar', reset: '2 mbar' }), '200 Pa')
  assert.equal(reset({ below: '10 mbar', reset: '10 mbar' }), '1000 Pa')
})

test('an alarm about a rise ends at half of it, or less by the hysteresis', () => {
  assert.equal(reset({ rise: 0.5 }), '0.25 decades/min')
  assert.equal(reset({ rise: 0.5, hysteresis: 0.1 }), '0.4 decades/min')
})

test('settings that the station refuses have no reset value', () => {
  for (const wrong of [
    { above: '10' },
    { above: '0 mbar' },
    { above: '10 mbar', reset: '11 mbar' },
    { below: '10 mbar', reset: '9 mbar' },
    { above: '10 mbar', reset: '2' },
    { above: '10 mbar', reset: '2 mbar', hysteresis: 0.1 },
    { above: '10 mbar', hysteresis: 11 },
    { above: '10 mbar', hysteresis: -1 },
    { above: '10 mbar', hysteresis: '1e' },
    { rise: 0 },
    { rise: 11 },
    { rise: 0.5, hysteresis: 'a' },
    {},
  ])
    assert.equal(reset(wrong), null, JSON.stringify(wrong))
})

test('only pressures and rises have a reset value among their settings', () => {
  assert.ok(hasReset({ above: '10 mbar' }) && hasReset({ below: '10 mbar' }) && hasReset({ rise: 0.5 }))
  assert.ok(!hasReset({ repetitions: 1 }) && !hasReset({ lost: 1 }) && !hasReset({ damaged: 1 }))
})

const reading = (series, quality, pa, limit_pa = null) => ({ series, quality, pa, limit_pa })
const GAUGES = [
  { age_ms: 0, stale_after_ms: 3_000, readings: [reading('vessel', 'valid', 500)] },
  {
    age_ms: 0,
    stale_after_ms: 3_000,
    readings: [reading('pump.1', 'underrange', null, 0.05), reading('pump.2', 'fault', null)],
  },
  { age_ms: 5_000, stale_after_ms: 3_000, readings: [reading('lock', 'valid', 2)] },
]

test('an alarm watches the pressures of its series; one that is not known is left out', () => {
  const watched = (series, more = null) =>
    watchedPressures({ series, several: more && { series: more } }, GAUGES, 0).map(
      ({ series, pa, quality }) => `${series} ${quality} ${pa}`,
    )
  assert.deepEqual(watched('vessel'), ['vessel valid 500'])
  assert.deepEqual(watched('pump.1'), ['pump.1 underrange 0.05'])
  for (const unknown of ['pump.2', 'lock', 'other', null]) assert.deepEqual(watched(unknown), [], `${unknown}`)
  const all = ['pump.1', 'lock', 'vessel', 'pump.2']
  assert.deepEqual(watched(null, all), ['pump.1 underrange 0.05', 'vessel valid 500'])
  assert.deepEqual(watchedPressures({ series: 'vessel', several: null }, GAUGES, 10_000), [])
})
