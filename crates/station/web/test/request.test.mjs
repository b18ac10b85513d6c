import assert from 'node:assert/strict'
import { afterEach, test } from 'node:test'
import { get, RequestError } from '../dist/test/api/request.js'

const { fetch } = globalThis
afterEach(() => {
  globalThis.fetch = fetch
})

/** Ends when its signal does, and not before. The timer of a signal alone does not keep the process waiting. */
function never(signal) {
  const waiting = setInterval(() => {}, 1_000)
  return new Promise((_, reject) => {
    const end = () => {
      clearInterval(waiting)
      reject(signal.reason)
    }
    if (signal.aborted) end()
    else signal.addEventListener('abort', end, { once: true })
  })
}

test('a request without an answer ends with a sentence', async () => {
  globalThis.fetch = (_, { signal }) => never(signal)
  await assert.rejects(get('/api/alarms', { limitMs: 1 }), (error) => {
    assert.ok(error instanceof RequestError)
    assert.match(error.message, /has not answered this request within 0\.001 s/)
    return error.status === 0
  })
})

test('an answer that stops in its middle is no answer', async () => {
  globalThis.fetch = async (_, { signal }) => ({ ok: true, status: 200, json: () => never(signal) })
  await assert.rejects(get('/api/alarms', { limitMs: 1 }), /has not answered this request/)
})

test('a request that the page gives up is no fault of the station', async () => {
  globalThis.fetch = (_, { signal }) => never(signal)
  const abort = new AbortController()
  const asked = get('/api/alarms', { signal: abort.signal })
  abort.abort(new Error('another page'))
  await assert.rejects(asked, /another page/)
})

test('an answer in time is the answer', async () => {
  globalThis.fetch = async () => ({ ok: true, status: 200, json: async () => [1] })
  assert.deepEqual(await get('/api/alarms', {}), [1])
})
