import assert from 'node:assert/strict'
import { test } from 'node:test'
import { changedDefault, defaultForm, effective } from '../dist/test/lib/default-alarms.js'

const NONE = { priority: null, delay: null, off_delay: null, limit: null, except: null }
const DEFAULTS = { ...NONE, priority: 'medium', delay: '15 s', off_delay: '2 s' }

test('a form without a change gives the settings that the station has sent', () => {
  for (const seen of [NONE, { ...NONE, delay: ' 3 s', except: [] }, { ...NONE, limit: 30, except: ['a', 'b c'] }])
    assert.deepEqual(changedDefault(seen, defaultForm(seen)), seen)
})

test('a changed field is a setting, and an empty one has its default', () => {
  const seen = { ...NONE, priority: 'high', delay: '30 s', limit: 30, except: ['spare'] }
  const form = { priority: 'off', delay: ' ', off_delay: '1 s ', limit: '100', except: ' a \n\nb, c\n' }
  const expected = { priority: 'off', delay: null, off_delay: '1 s', limit: 100, except: ['a', 'b, c'] }
  assert.deepEqual(changedDefault(seen, form), expected)
  assert.deepEqual(changedDefault(seen, { ...form, limit: '', except: '' }), { ...expected, limit: null, except: null })
})

test('the settings that hold are those of the file, else the defaults', () => {
  assert.equal(effective({ name: 'stale', settings: NONE, defaults: DEFAULTS }), 'medium, after 15 s, ends after 2 s')
  const settings = { ...NONE, priority: 'low', except: ['spare', 'lock'] }
  const text = 'low, after 15 s, ends after 2 s, above 30 telegrams per minute, except spare, lock'
  assert.equal(effective({ name: 'damage', settings, defaults: { ...DEFAULTS, limit: 30 } }), text)
  assert.equal(effective({ name: 'stale', settings: { ...NONE, priority: 'off' }, defaults: DEFAULTS }), 'off')
})
