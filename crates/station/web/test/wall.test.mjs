import assert from 'node:assert/strict'
import { test } from 'node:test'
import {
  alarmLines,
  gridOf,
  hasNoGauge,
  isShared,
  pageAt,
  pagesOf,
  sharedTiles,
  silentText,
  TURN_MS,
  tilesOf,
} from '../dist/test/lib/wall.js'

test('few tiles are large, and many are not narrower than can be read', () => {
  assert.deepEqual(gridOf(1, 1920, 1000), { columns: 1, rows: 1, width: 1920, height: 1000 })
  assert.deepEqual(gridOf(6, 1920, 1000), { columns: 3, rows: 3, width: 640, height: 333 })
  assert.deepEqual(gridOf(480, 1920, 1000), { columns: 5, rows: 5, width: 384, height: 200 })
  for (const [count, width, height] of [
    [0, 0, 0],
    [5, 100, 50],
    [1000, 7680, 4320],
  ]) {
    const { columns, rows } = gridOf(count, width, height)
    assert.ok(columns >= 1 && rows >= 1, `${count} ${width} ${height}`)
  }
})

test('every tile has a page, problems stay on all pages, and a page is never longer than the display', () => {
  const names = (letter, count) => Array.from({ length: count }, (_, number) => `${letter}${number}`)
  assert.deepEqual(pagesOf(['p0'], ['o0'], 2), [['p0', 'o0']])
  for (const [problems, others, perPage] of [
    [0, 7, 3],
    [2, 40, 6],
    [9, 4, 5],
    [30, 0, 4],
    [3, 3, 1],
  ]) {
    const all = [...names('p', problems), ...names('o', others)]
    const pages = pagesOf(names('p', problems), names('o', others), perPage)
    assert.deepEqual([...new Set(pages.flat())].sort(), all.sort())
    assert.ok(pages.every((page) => page.length > 0 && page.length <= perPage))
  }
  const pages = pagesOf(['p0', 'p1'], names('o', 10), 6)
  assert.equal(pages.length, 3)
  assert.ok(pages.every((page) => page[0] === 'p0' && page[1] === 'p1'))
})

test('the gauges of a segment share a tile when there would be more than five pages', () => {
  // 25 tiles fit into the window.
  assert.deepEqual(
    [1, 125, 126, 480].map((readings) => isShared(readings, 1920, 1000)),
    [false, false, true, true],
  )
})

test('a controller with a problem is not among the gauges without one, and its quiet channels keep their tiles', () => {
  const gauge = (name, segment) => ({ name, segment })
  const [tpg, one, two] = [gauge('tpg', 'a'), gauge('one', 'a'), gauge('two', 'b')]
  const tile = (gauge, channel) => ({ gauge, channel })
  const others = sharedTiles(
    [tile(tpg, 2)],
    [tile(tpg, 1), tile(one, 1), tile(two, 1), tile(two, 2), tile(tpg, 3)],
    ['a', 'b', 'c'],
  )
  assert.deepEqual(others, [
    tile(tpg, 1),
    tile(tpg, 3),
    { segment: 'a', gauges: [one] },
    { segment: 'b', gauges: [two] },
  ])
})

test('pages turn with the clock of the station', () => {
  assert.deepEqual(
    [0, TURN_MS - 1, TURN_MS, 3 * TURN_MS].map((now) => pageAt(now, 3)),
    [0, 0, 1, 0],
  )
  assert.equal(pageAt(5, 0), 0)
})

const alarm = (name, gauge, series = null, state = 'unacknowledged', priority = 'medium') => ({
  ...{ name, gauge, series, state, priority },
  since_ms: 0,
})
const names = (alarms) => alarms.map(({ name }) => name)

test('an alarm stands on the tile of its reading, one of the whole gauge once, and one that has cleared nowhere', () => {
  const readings = [{ series: 'img.1' }, { series: 'img.2' }, { series: 'img.3' }]
  const tiles = tilesOf(
    readings,
    [alarm('fault', 'img'), alarm('above', 'img', 'img.2'), alarm('over', 'img', 'img.3', 'returned')],
    true,
  )
  assert.deepEqual(
    tiles.map(({ reading, alarms }) => [reading?.series ?? 'whole', ...names(alarms)]),
    [['whole', 'fault'], ['img.1'], ['img.2', 'above'], ['img.3']],
  )
  assert.equal(tilesOf(readings, [alarm('above', 'img', 'img.2')], false).length, 3)
  assert.deepEqual(tilesOf(readings, [], true)[0], { reading: null, alarms: [] })
  assert.deepEqual(
    tilesOf([{ series: 'ion' }], [alarm('above', 'ion', 'ion'), alarm('stale', 'ion')], true).map(({ alarms }) =>
      names(alarms),
    ),
    [['above', 'stale']],
  )
  const [silent] = tilesOf([], [alarm('stale', 'lost')], false)
  assert.deepEqual([silent.reading, names(silent.alarms)], [null, ['stale']])
})

test('alarms without a tile have lines, the most urgent first, and the rest is counted', () => {
  const down = (name, priority, state) => alarm(name, null, null, state, priority)
  const all = [
    alarm('fault', 'ion'),
    down('a', 'low'),
    down('b', 'high'),
    down('cleared', 'high', 'returned'),
    alarm('removed', 'gone'),
    down('c', 'low'),
    down('d', 'low'),
  ]
  const others = all.filter((one) => hasNoGauge(one, [{ name: 'ion' }]))
  const { lines, more } = alarmLines(others)
  assert.deepEqual([names(lines), more], [['b', 'removed', 'a'], 2])
  assert.deepEqual(alarmLines(others.slice(0, 1)), { lines: [all[1]], more: 0 })
})

test('the head of the wall names declared plant states and counts the alarms that are silent', () => {
  const silent = (names, suppressed, shelved, out_of_service) =>
    silentText({ plant_states: names.map((name) => ({ name })), suppressed, shelved, out_of_service })
  assert.equal(silent([], 0, 0, 0), '')
  assert.equal(silent(['Vented'], 4, 1, 1), 'Plant state: Vented · 4 suppressed, 1 shelved, 1 out of service')
  assert.equal(silent([], 0, 0, 2), '2 out of service')
  assert.equal(silent(['Vented', 'Bakeout'], 0, 0, 0), 'Plant state: Vented, Bakeout')
})
