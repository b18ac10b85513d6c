import assert from 'node:assert/strict'
import { readFileSync } from 'node:fs'
import { test } from 'node:test'
import { CURVE_COLOURS, curveColours } from '../dist/test/lib/curves.js'

/** The colours of the design tokens, `light-dark(#…, #…)`. */
const TOKENS = new Map(
  [
    ...readFileSync(new URL('../src/styles/tokens.css', import.meta.url), 'utf8').matchAll(
      /--([\w-]+): light-dark\((#\w{6}), (#\w{6})\)/g,
    ),
  ].map(([, name, light, dark]) => [name, { light, dark }]),
)

const linear = (colour) =>
  [1, 3, 5].map((at) => {
    const part = Number.parseInt(colour.slice(at, at + 2), 16) / 255
    return part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4
  })

/** CIE L*a*b*, in which the distance of two colours is about how different they look. */
function lab(colour) {
  const [r, g, b] = linear(colour)
  const [x, y, z] = [
    (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.95047,
    0.2126 * r + 0.7152 * g + 0.0722 * b,
    (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.08883,
  ].map((part) => (part > 0.008856 ? Math.cbrt(part) : 7.787 * part + 16 / 116))
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)]
}

const distance = (one, other) => Math.hypot(...lab(one).map((part, index) => part - lab(other)[index]))

function contrast(one, other) {
  const [r, s] = [one, other].map((colour) => {
    const [red, green, blue] = linear(colour)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue + 0.05
  })
  return Math.max(r, s) / Math.min(r, s)
}

test('no curve has a colour close to that of an alarm, and each is visible on its ground', () => {
  for (const [theme, colours] of Object.entries(CURVE_COLOURS)) {
    for (const colour of colours) {
      for (const alarm of ['bad', 'warn', 'low'])
        assert.ok(distance(colour, TOKENS.get(alarm)[theme]) > 35, `${theme} ${colour} ${alarm}`)
      const others = colours.filter((other) => other !== colour)
      assert.ok(Math.min(...others.map((other) => distance(colour, other))) > 25, `${theme} ${colour}`)
      // The colour is also that of the name of the curve.
      assert.ok(contrast(colour, TOKENS.get('panel')[theme]) >= 4.5, `${theme} ${colour}`)
    }
  }
})

test('chosen curves have different colours while there are enough', () => {
  const names = Array.from({ length: 20 }, (_, index) => `${index}`)
  const colours = curveColours(names, ['0', '8', '16'], false)
  assert.equal(new Set(['0', '8', '16'].map((name) => colours.get(name))).size, 3)
})
