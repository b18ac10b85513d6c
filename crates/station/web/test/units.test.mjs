import assert from 'node:assert/strict'
import { test } from 'node:test'
import { quantity } from '../dist/test/lib/alarms.js'
import {
  age,
  clock,
  decade,
  fileSize,
  moment,
  momentOf,
  number,
  parts,
  quantities,
  ratio,
  readable,
  withLocalTimes,
} from '../dist/test/lib/format.js'
import { inUnit, isUnit, nextUnit, UNIT_NAMES } from '../dist/test/lib/units.js'

test('one pascal in every unit', () => {
  const pascals = { mbar: 100, hPa: 100, Torr: 133.322368, micron: 0.133322368, Pa: 1 }
  assert.deepEqual(UNIT_NAMES, Object.keys(pascals))
  for (const unit of UNIT_NAMES) assert.ok(Math.abs(inUnit(pascals[unit], unit) - 1) < 1e-12, unit)
  assert.ok(Math.abs(inUnit(101325, 'Torr') - 760) < 1e-3)
})

test('the next unit after the last is the first', () => {
  assert.equal(nextUnit('mbar'), 'hPa')
  assert.equal(nextUnit('Pa'), 'mbar')
  assert.ok(isUnit('Torr') && !isUnit('psi') && !isUnit(null))
})

test('pressures have three digits', () => {
  for (const [value, text] of [
    [1.234e-6, '1.23 × 10⁻⁶'],
    [9.996e-11, '1.00 × 10⁻¹⁰'],
    [0.5, '5.00 × 10⁻¹'],
    [0.9999, '1.00'],
    [1, '1.00'],
    [9.996, '10.0'],
    [12.34, '12.3'],
    [99.96, '100'],
    [1013.25, '1013'],
    [9999.4, '9999'],
    [9999.6, '1.00 × 10⁴'],
    [101325, '1.01 × 10⁵'],
    [0, '0'],
  ])
    assert.equal(number(value), text)
  assert.deepEqual(parts(2.5e-9), { mantissa: '2.50', exponent: -9 })
})

test('ratios from a thousandth on have no power of ten', () => {
  const texts = [0, 0.0005, 0.001, 0.92519, 0.9999, 1, 3.614, 123.4].map(ratio)
  assert.deepEqual(texts, ['0', '5.00 × 10⁻⁴', '0.001', '0.925', '1.00', '1.00', '3.61', '123'])
})

test('sizes of files have three digits and the largest unit that fits', () => {
  const texts = [0, 512, 3100, 24_000_000, 5.2e9].map((octets) => fileSize(octets).replace('\u00a0', ' '))
  assert.deepEqual(texts, ['0 B', '512 B', '3.10 kB', '24.0 MB', '5.20 GB'])
})

test('axes have powers of ten, plain ones where they are short', () => {
  assert.deepEqual([1e-10, 0.1, 1, 10, 1000, 1e4].map(decade), ['10⁻¹⁰', '10⁻¹', '1', '10', '1000', '10⁴'])
})

test('ages have at most two units', () => {
  for (const [ms, text] of [
    [12, 'less than 1 s'],
    [3_140, '3.1 s'],
    [42_000, '42 s'],
    [185_000, '3 min 5 s'],
    [3_600_000, '1 h'],
    [3_605_000, '1 h'],
    [187_200_000, '2 d 4 h'],
  ])
    assert.equal(age(ms), text)
})

test('times are in the time zone of the browser', () => {
  const at = new Date(2026, 0, 31, 4, 5, 6).getTime()
  assert.equal(clock(at), '04:05:06')
  assert.equal(moment(at), '2026-01-31 04:05:06')
  assert.equal(momentOf(moment(at)), at)
  assert.equal(momentOf('2026-01-31 04:05'), at - 6_000)
  for (const wrong of ['', '1/31/2026 4:05 AM', '2026-13-31 04:05', '04:05']) assert.equal(momentOf(wrong), null, wrong)
})

test('long numbers of the station are rounded for reading', () => {
  assert.equal(readable('it is 4.5095703e-8 mbar'), 'it is 4.51 × 10⁻⁸ mbar')
  assert.equal(readable('ba.process-value is below 7.2e-6 mbar'), 'ba.process-value is below 7.20 × 10⁻⁶ mbar')
  assert.equal(readable('the emission is on'), 'the emission is on')
  assert.equal(
    readable('alarm "lock above 3e-5 mbar" raised: lock shows 6.04e-5 mbar'),
    'alarm "lock above 3e-5 mbar" raised: lock shows 6.04 × 10⁻⁵ mbar',
  )
})

test('times of the station are those of the time zone of the browser, and the audit trail keeps its numbers', () => {
  const at = new Date(2026, 10, 28, 18, 52, 58)
  const [local, utc] = [moment(at.getTime()), at.toISOString().replace('.000', '')]
  const words = utc.replace('T', ' ').replace('Z', ' UTC')
  assert.equal(readable(`declared until ${utc}`), `declared until ${local}`)
  assert.equal(readable(`${words}, for 90.0 s`), `${local}, for 90.0 s`)
  assert.equal(
    withLocalTimes(`"${utc}" 4.5095703e-8 mbar until ${utc}, ${words}`),
    `"${utc}" 4.5095703e-8 mbar until ${local}, ${local}`,
  )
})

test('a number and its unit, a day and its time are one part of a text, and no character is lost', () => {
  const kept = (text) => quantities(text).filter((_, index) => index % 2 === 1)
  assert.deepEqual(kept('cryostat above 1e-4 mbar'), ['1e-4 mbar'])
  assert.deepEqual(kept('shows 5.00 × 10⁻³ mbar, not above 1013\u00a0mbar'), ['5.00 × 10⁻³ mbar', '1013\u00a0mbar'])
  assert.deepEqual(kept('raised 2026-01-31 14:03:22, 3 min 5 s ago'), ['2026-01-31 14:03:22', '3 min', '5 s'])
  assert.deepEqual(kept('rises faster than 0.50 decades/min'), ['0.50 decades/min'])
  assert.deepEqual(kept('about 5, 15, 80 %'), ['80 %'])
  assert.deepEqual(kept('gate 2 has 3 samples, 1: s05-35, 2 duds'), [])
  const text = 'lock above 3e-5 mbar for 2 h'
  assert.equal(quantities(text).join(''), text)
})

test('a rate has the minus of the other numbers, and none where it is zero', () => {
  const rate = (value) => quantity(value, 'decades/min', 'mbar').replaceAll('\u00a0', ' ')
  assert.deepEqual([-0.06, -0.004, 0, 0.5].map(rate), [
    '−0.06 decades/min',
    '0.00 decades/min',
    '0.00 decades/min',
    '0.50 decades/min',
  ])
})
