import assert from 'node:assert/strict'
import { test } from 'node:test'
import { createHub } from '../dist/test/lib/stream-hub.js'

const OPTIONS = { silenceMs: 6_000, byName: ['gauges'] }

/** A hub with a clock and streams of the test. */
function begin() {
  const opened = []
  const clock = { now: 0 }
  const open = () => {
    const listeners = {}
    const source = {
      readyState: 0,
      close: () => {
        source.readyState = 2
      },
      addEventListener: (name, listener) => {
        listeners[name] = listener
      },
      emit: (name, data) => listeners[name]({ data: JSON.stringify(data) }),
    }
    opened.push(source)
    return source
  }
  const hub = createHub(OPTIONS, open, () => clock.now)
  const window = () => {
    const heard = []
    const member = (message) => heard.push(message)
    return { member, heard, kinds: () => heard.map(({ kind }) => kind) }
  }
  return { hub, opened, clock, window, open: () => opened.filter(({ readyState }) => readyState !== 2).length }
}

test('ten windows share one stream, and each has the whole state at once', () => {
  const { hub, opened, clock, window, open } = begin()
  const windows = Array.from({ length: 10 }, window)
  for (const { member } of windows.slice(0, 9)) hub.join(member, 'ada')
  opened[0].emit('snapshot', { revision: 1, gauges: { a: 1, b: 2 } })
  opened[0].emit('change', { gauges: { b: null, c: 3 } })
  clock.now = 250
  const last = windows[9]
  hub.join(last.member, 'ada')
  assert.equal(opened.length, 1)
  const [{ kind, data, ageMs }] = last.heard
  assert.deepEqual([kind, JSON.parse(data), ageMs], ['snapshot', { revision: 1, gauges: { a: 1, c: 3 } }, 250])
  opened[0].emit('change', { revision: 2 })
  assert.deepEqual(windows[0].kinds(), ['snapshot', 'change', 'change'])
  assert.deepEqual(last.kinds(), ['snapshot', 'change'])
  // The first window to come is not needed for the others.
  for (const { member } of windows.slice(0, 9)) hub.leave(member)
  assert.equal(open(), 1)
  hub.leave(last.member)
  assert.equal(open(), 0)
})

test('a window that comes back has a stream and is not shown the state from before', () => {
  const { hub, opened, window, open } = begin()
  const { member, kinds } = window()
  hub.join(member, 'ada')
  opened[0].emit('snapshot', { gauges: {} })
  hub.leave(member)
  hub.join(member, 'ada')
  assert.deepEqual([open(), kinds()], [1, ['snapshot']])
})

test('another session has a stream of its own, and windows of the former one ask for theirs', () => {
  const { hub, opened, window, open } = begin()
  const [olga, ada] = [window(), window()]
  hub.join(olga.member, 'olga')
  opened[0].emit('snapshot', { gauges: { secret: 1 } })
  hub.join(ada.member, 'ada')
  assert.deepEqual([ada.kinds(), olga.kinds()], [[], ['snapshot', 'ended']])
  assert.deepEqual([open(), opened.length], [1, 2])
  // An event of the former stream that was under way is nobody's.
  opened[0].emit('change', { gauges: { secret: 2 } })
  assert.deepEqual(ada.heard, [])
  opened[1].emit('snapshot', { gauges: {} })
  // The other window has learnt of the new session, and joins it without a new stream.
  hub.join(olga.member, 'ada')
  assert.deepEqual([opened.length, ada.kinds()], [2, ['snapshot']])
})

test('a stream that is refused or silent is opened again, and every window asks whether its session has ended', () => {
  const { hub, opened, clock, window } = begin()
  const { member, kinds } = window()
  hub.join(member, 'ada')
  hub.check()
  assert.equal(opened.length, 1)
  opened[0].readyState = 2
  hub.check()
  assert.deepEqual([opened.length, kinds()], [2, ['ended']])
  opened[1].emit('snapshot', { gauges: {} })
  clock.now = 6_000
  hub.check()
  assert.equal(opened.length, 2, 'not silent for long enough')
  clock.now = 6_001
  hub.check()
  assert.deepEqual([opened.length, kinds()], [3, ['ended', 'snapshot', 'ended']])
  // The state stays, with its age, until the new stream has one.
  const late = window()
  hub.join(late.member, 'ada')
  assert.equal(late.heard[0].ageMs, 6_001)
  opened[2].emit('error')
  assert.deepEqual(kinds().at(-1), 'ended')
})
