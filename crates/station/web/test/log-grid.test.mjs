import assert from 'node:assert/strict'
import { test } from 'node:test'
import { areNamed, digitOf, isNamed, minorDigits, minorValues, namedValues } from '../dist/test/lib/log-grid.js'

const rounded = (values) => values.map((value) => Number(value.toPrecision(6)))

test('a logarithmic axis names 2 and 5 of each decade where there is room, and then whole decades only', () => {
  assert.deepEqual(rounded(namedValues(1e-3, 1e-1, 200, 18)), [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1])
  assert.deepEqual(rounded(namedValues(1e-3, 1e-1, 100, 18)), [0.001, 0.01, 0.1])
  assert.deepEqual(rounded(namedValues(1e-8, 1, 72, 18)), [1e-8, 1e-6, 1e-4, 1e-2, 1])
  assert.ok(areNamed(60, 18) && !areNamed(59, 18))
  assert.deepEqual([1, 2, 3, 4, 5, 6, 7, 8, 9].filter(isNamed), [2, 5])
})

test('the numbers 2 to 9 of each decade have lines, unless the decades are short', () => {
  assert.deepEqual(rounded(minorValues(1, 100, 100)), [2, 3, 4, 5, 6, 7, 8, 9, 20, 30, 40, 50, 60, 70, 80, 90])
  assert.deepEqual(minorValues(1e-8, 1e5, 300), [])
  assert.deepEqual([minorDigits(23).length, minorDigits(24).length], [0, 8])
  assert.deepEqual(minorValues(1, 1, 100), [])
})

test('the digit of a number on the axis, and none of a power of ten', () => {
  for (let exponent = -12; exponent <= 6; exponent += 1) {
    assert.equal(digitOf(10 ** exponent), null, String(exponent))
    for (const digit of [2, 5]) assert.equal(digitOf(digit * 10 ** exponent), digit, String(exponent))
  }
})
