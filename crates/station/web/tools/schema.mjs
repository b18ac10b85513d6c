// Generates src/api/schema.d.ts from openapi.json: `node schema.mjs` writes it, `node schema.mjs --check` compares.

import { readFile, writeFile } from 'node:fs/promises'
import openapiTS, { astToString } from 'openapi-typescript'

const DESCRIPTION = new URL('../openapi.json', import.meta.url)
const TYPES = new URL('../src/api/schema.d.ts', import.meta.url)

/**
 * The values of properties that the description calls a plain string. As soon as the description lists the values of one,
 * its entry here must go: the generator refuses it.
 */
const VALUES = {
  'AlarmView.condition': ['above', 'below', 'rise', 'blind', 'fault', 'stale', 'down', 'damage', 'unrecorded'],
  'AlarmHistoryView.what': [
    'raised',
    'returned',
    'acknowledged',
    'taken-out-of-service',
    'returned-to-service',
    'removed',
  ],
  'AlarmHistoryView.state': ['normal', 'unacknowledged', 'acknowledged', 'returned', 'out-of-service'],
  'AlarmHistoryView.priority': ['low', 'medium', 'high'],
  'EventView.kind': ['station', 'bus', 'gauge', 'command', 'note', 'access', 'alarm'],
  'Reading.principle': ['pirani', 'hot-cathode', 'cold-cathode', 'diaphragm', 'atmosphere'],
  'Reading.quality': ['valid', 'overrange', 'underrange', 'invalid', 'gap'],
}

/** Lists the values of the properties in VALUES. */
function listValues(schemas) {
  for (const [place, values] of Object.entries(VALUES)) {
    const [schema, property] = place.split('.')
    const described = schemas[schema]?.properties?.[property]
    const types = [described?.type].flat()
    if (!types.includes('string') || described.enum)
      throw new Error(`${place} is no plain string: remove it from VALUES`)
    described.enum = types.includes('null') ? [...values, null] : values
  }
}

const description = JSON.parse(await readFile(DESCRIPTION, 'utf8'))
listValues(description.components.schemas)
const types = `// Generated from openapi.json by \`npm run generate\`. Do not edit.\n\n${astToString(await openapiTS(description))}`

if (process.argv.includes('--check')) {
  if ((await readFile(TYPES, 'utf8')) !== types) throw new Error('src/api/schema.d.ts is out of date: npm run generate')
} else {
  await writeFile(TYPES, types)
}
