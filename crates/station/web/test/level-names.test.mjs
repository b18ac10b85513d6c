import assert from 'node:assert/strict'
import { test } from 'node:test'
import { freePlace, namePlaces } from '../dist/test/lib/level-names.js'

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

test('the name of a band stands where no other name is, and nowhere if there is no room', () => {
  const size = { width: 100, height: 12 }
  const level = { left: 8, top: 40, width: 95, height: 12 }
  assert.equal(freePlace([130, 4], [41], size, [level]).left, 130)
  assert.deepEqual(freePlace([4, 104], [41], size, [level]), { left: 104, top: 41, ...size })
  assert.deepEqual(freePlace([4], [41, 28], size, [level]), { left: 4, top: 28, ...size })
  assert.equal(freePlace([4], [41, 35], size, [level]), null)
})
