import assert from 'node:assert/strict'
import { test } from 'node:test'
import { along, extent, firstFree, placesAtCurve, placesAtLine, profileOf } from '../dist/test/lib/name-places.js'

const PLOT = { width: 400, height: 300 }
const SIZE = { width: 60, height: 12 }

/** A curve at the same height everywhere. */
const flat = (y) =>
  profileOf(
    [
      [0, y],
      [PLOT.width, y],
    ],
    PLOT.width,
  )

const place = (places, rects, curves) => firstFree(places, { rects, curves }, PLOT)

test('a profile follows a steep piece and breaks at a gap', () => {
  const profile = profileOf([[0, 10], [1, 10], [2, 110], null, [4, 50], [5.5, 50]], 8)
  assert.deepEqual(profile[0], [10, 10])
  assert.deepEqual(profile[1], [10, 110])
  assert.equal(profile[3], null)
  assert.deepEqual(profile[4], [50, 50])
  assert.deepEqual(profile[5], [50, 50])
  assert.equal(profile[6], null)
  assert.deepEqual(extent(profile, 0, 5), [10, 110])
  assert.equal(extent(profile, 6, 8), null)
})

test('a profile ends at the edges of the plot', () => {
  const profile = profileOf(
    [
      [-10, 0],
      [20, 300],
    ],
    5,
  )
  assert.equal(profile.length, 5)
  assert.deepEqual(profile[0], [100, 110])
})

test('the name of a line stands above it, and where a curve passes further along or below it', () => {
  const places = placesAtLine(100, SIZE, PLOT)
  assert.deepEqual(place(places, [], []), { left: 8, top: 85, ...SIZE })
  const crossing = profileOf(
    [
      [30, 0],
      [40, 200],
    ],
    PLOT.width,
  )
  assert.equal(place(places, [], [crossing]).top, 85)
  assert.ok(place(places, [], [crossing]).left > 40 - 8)
  assert.deepEqual(place(places, [], [flat(90)]), { left: 8, top: 103, ...SIZE })
})

test('the names of lines that are close to each other stand beside each other', () => {
  const first = place(placesAtLine(100, SIZE, PLOT), [], [])
  const second = place(placesAtLine(102, SIZE, PLOT), [first], [])
  assert.ok(second.left >= first.left + SIZE.width || second.top >= first.top + SIZE.height)
})

test('the name of a line at the upper edge stands below the line', () => {
  assert.equal(place(placesAtLine(0, SIZE, PLOT), [], []).top, 3)
})

test('the name of a curve stands at its end, above it or below it, and on no other curve', () => {
  const end = PLOT.width - 4 - SIZE.width
  const own = flat(150)
  assert.deepEqual(place(placesAtCurve(own, SIZE, PLOT), [], [own]), { left: end, top: 135, ...SIZE })
  assert.deepEqual(place(placesAtCurve(own, SIZE, PLOT), [], [own, flat(140)]), { left: end, top: 153, ...SIZE })
  const between = place(
    placesAtCurve(own, SIZE, PLOT),
    [],
    [
      own,
      flat(140),
      profileOf(
        [
          [300, 160],
          [400, 160],
        ],
        400,
      ),
    ],
  )
  assert.ok(between.left + SIZE.width <= 301)
  assert.equal(between.top, 153)
})

test('the name of a curve with a peak at its end stands before the peak', () => {
  const peak = profileOf(
    [
      [0, 150],
      [370, 150],
      [380, 20],
      [390, 150],
      [400, 150],
    ],
    PLOT.width,
  )
  const found = place(placesAtCurve(peak, SIZE, PLOT), [], [peak])
  assert.equal(found.top, 135)
  assert.ok(found.left + SIZE.width <= 371)
})

test('the name of a curve that ended stands where it ended', () => {
  const short = profileOf(
    [
      [0, 150],
      [200, 150],
    ],
    PLOT.width,
  )
  const found = place(placesAtCurve(short, SIZE, PLOT), [], [short])
  assert.ok(found.left + SIZE.width <= 201 && found.left > 100)
  assert.deepEqual(placesAtCurve(profileOf([], PLOT.width), SIZE, PLOT), [])
})

test('a name keeps clear of a curve above it', () => {
  const name = { left: 10, top: 20, ...SIZE }
  assert.equal(place([name], [], [flat(19)]), null)
  assert.deepEqual(place([name], [], [flat(17)]), name)
  assert.equal(place([name], [], [flat(33)]), null)
})

test('no name leaves the plot, and there is none without room', () => {
  assert.equal(place([{ left: 350, top: 20, ...SIZE }], [], []), null)
  assert.equal(place([{ left: 10, top: -1, ...SIZE }], [], []), null)
  assert.equal(place([{ left: 10, top: 20, ...SIZE }], [{ left: 60, top: 30, width: 5, height: 5 }], []), null)
  assert.deepEqual(place([{ left: 10, top: 20, ...SIZE }], [{ left: 70, top: 20, ...SIZE }], [])?.left, 10)
})

test('places along a row begin at either end', () => {
  assert.deepEqual(along(0, 50), [0, 24, 48])
  assert.deepEqual(along(0, 50, true), [50, 26, 2])
  assert.deepEqual(along(10, 5), [])
})
