import assert from 'node:assert/strict'
import { test } from 'node:test'
import { namePlaces } from '../dist/test/lib/level-names.js'

test('the names of lines that are close to each other stand beside each other', () => {
  const [first, second, far] = namePlaces([
    { y: 100, width: 120 },
    { y: 105, width: 60 },
    { y: 200, width: 60 },
  ])
  assert.ok(second.x >= first.x + 120)
  assert.equal(first.y, 85)
  assert.equal(far.x, first.x)
})

test('the name of a line at the upper edge stands below the line', () => {
  const [{ y }] = namePlaces([{ y: 0, width: 50 }])
  assert.ok(y > 0)
})
