import assert from 'node:assert/strict'
import { test } from 'node:test'
import { ofStation, viewPath, viewsIn, withoutView, withView } from '../dist/test/lib/views.js'

const view = (name, query = 'group=a', page = '/') => ({ name, page, query })
const NONE = { search: null, group: null, tag: null, location: null, state: null, series: [] }

test('a view of the station is an address of its page', () => {
  const filter = ofStation({ ...NONE, name: 'a', group: 'ring, inside', state: 'no-data' }, [])
  assert.equal(viewPath(filter), '/?group=ring%2C+inside&state=no-data')
  const gauges = [{ name: 'tpg', readings: [{ series: 'tpg.1' }, { series: 'tpg.2' }] }]
  assert.equal(
    viewPath(ofStation({ ...NONE, name: 'a', series: ['tpg', 'x y'] }, gauges)),
    '/trends?s=tpg.1&s=tpg.2&s=x+y',
  )
})

test('what a browser has stored is read, and everything else is left out', () => {
  const views = [view('a'), view('b', 's=x', '/trends')]
  assert.deepEqual(viewsIn(JSON.stringify(views)), views)
  const wrong = [
    null,
    5,
    {},
    view(''),
    view('x'.repeat(41)),
    view('a', ''),
    view('a', 'q=1', '//evil.example'),
    view('a', 'q=1', 'toString'),
  ]
  assert.deepEqual(viewsIn(JSON.stringify([...wrong, view('c')])), [view('c')])
  for (const text of [null, '', '{', '{}', '"a"']) assert.deepEqual(viewsIn(text), [])
})

test('a view of the same name and page is replaced, and the number and length of views are limited', () => {
  const two = withView(withView([], view('b')), view('a'))
  assert.deepEqual(
    two.map(({ name }) => name),
    ['a', 'b'],
  )
  assert.deepEqual(withView(two, view('b', 'tag=x')), [view('a'), view('b', 'tag=x')])
  assert.equal(withView(two, view('b', 's=x', '/trends')).length, 3)
  assert.deepEqual(withoutView(two, view('a')), [view('b')])
  const many = Array.from({ length: 100 }, (_, number) => view(`v${number}`))
  assert.match(withView(many, view('one more')), /at most 100 views/)
  assert.equal(withView(many, view('v5', 'tag=x')).length, 100)
  assert.match(withView([], view('a', 'x'.repeat(4001))), /too many series/)
})
