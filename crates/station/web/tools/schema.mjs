// Generates src/api/schema.d.ts from openapi.json: `node schema.mjs` writes it, `node schema.mjs --check` compares.

import { readFile, writeFile } from 'node:fs/promises'
import openapiTS, { astToString } from 'openapi-typescript'

const DESCRIPTION = new URL('../openapi.json', import.meta.url)
const TYPES = new URL('../src/api/schema.d.ts', import.meta.url)

const description = JSON.parse(await readFile(DESCRIPTION, 'utf8'))
const types = `// Generated from openapi.json by \`npm run generate\`. Do not edit.\n\n${astToString(await openapiTS(description))}`

if (process.argv.includes('--check')) {
  if ((await readFile(TYPES, 'utf8')) !== types) throw new Error('src/api/schema.d.ts is out of date: npm run generate')
} else {
  await writeFile(TYPES, types)
}
