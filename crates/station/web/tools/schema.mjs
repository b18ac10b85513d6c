// Generates the types of both APIs from their descriptions: `node schema.mjs` writes them, `node schema.mjs --check` compares.

import { readFile, writeFile } from 'node:fs/promises'
import openapiTS, { astToString } from 'openapi-typescript'

/** A description, and the types that are generated from it. */
const APIS = [
  ['../openapi.json', '../src/api/schema.d.ts'],
  ['../archive-openapi.json', '../src/archive/schema.d.ts'],
]

for (const [description, types] of APIS) {
  const [from, to] = [new URL(description, import.meta.url), new URL(types, import.meta.url)]
  const name = description.slice('../'.length)
  const ast = await openapiTS(JSON.parse(await readFile(from, 'utf8')))
  const text = `// Generated from ${name} by \`npm run generate\`. Do not edit.\n\n${astToString(ast)}`
  if (!process.argv.includes('--check')) await writeFile(to, text)
  else if ((await readFile(to, 'utf8')) !== text)
    throw new Error(`${types.slice('../'.length)} is out of date: npm run generate`)
}
