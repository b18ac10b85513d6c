import assert from 'node:assert/strict'
import { test } from 'node:test'
import { commandWords, inUse, operatingStates } from '../dist/test/lib/commands.js'

const commands = (...names) => names.map((command) => ({ command }))
const names = (list) => list.map(({ command }) => command)

test('commands of the measuring parts come first in the order of their use, those of the device are apart', () => {
  const all = commands(
    'device.inactive',
    'device.reset',
    'device.abort',
    'atmosphere.atmosphere-adjust',
    'ba.emission-off',
    'ba.degas-off',
    'ba.degas-on',
    'ba.inactive',
    'device.ready-to-store',
  )
  const { parts, device } = inUse(all)
  assert.deepEqual(names(parts), ['ba.degas-on', 'ba.degas-off', 'ba.emission-off', 'atmosphere.atmosphere-adjust'])
  assert.deepEqual(names(device), ['device.reset', 'device.abort'])
})

test('a command has words, with its part where two parts have it, and its name where a device file gave it another', () => {
  const all = commands('ba.degas-on', 'pirani.zero-adjust', 'cdg.zero-adjust', 'ba.bake')
  assert.deepEqual(
    names(all).map((name) => commandWords(name, all)),
    ['Degas', 'Adjust zero: pirani', 'Adjust zero: cdg', 'ba.bake'],
  )
  assert.equal(commandWords('constructor', []), 'constructor')
})

test('emission and degas are those that the station watches, otherwise as they were read with all parameters', () => {
  const parameter = (target, value) => ({ target, name: target, value })
  const blocks = [
    { name: 'BA', parameters: [parameter('ba.degas-status', 'off'), parameter('ba.emission-status', 'on')] },
    { name: 'other', parameters: [parameter('ba.filter', '3'), parameter('ba.emission-current', null)] },
  ]
  const watched = (target, text, quality = 'valid') => ({ target, name: target, text, quality })
  const states = (parameters, blocks) =>
    operatingStates({ parameters }, blocks).map(({ target, text }) => [target, text])
  assert.deepEqual(states([], blocks), [
    ['ba.degas-status', 'off'],
    ['ba.emission-status', 'on'],
  ])
  const fresh = [watched('ba.degas-status', 'degas'), watched('ba.emission-status', '', 'stale')]
  assert.deepEqual(states(fresh, blocks), [
    ['ba.degas-status', 'degas'],
    ['ba.emission-status', 'on'],
  ])
  assert.deepEqual(states([], null), [])
})
