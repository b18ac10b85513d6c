// Writes NAME.br and NAME.gz beside each file below a folder that they make smaller: `node compress.mjs FOLDER`. The program embeds them, so no
// request waits for a compression.
import { readFileSync, readdirSync, writeFileSync } from 'node:fs'
import { join } from 'node:path'
import { brotliCompressSync, constants, gzipSync } from 'node:zlib'

const folder = process.argv[2]
for (const entry of readdirSync(folder, { recursive: true, withFileTypes: true })) {
  if (!entry.isFile() || !/\.(css|html|js|svg)$/.test(entry.name)) continue
  const file = join(entry.parentPath ?? entry.path, entry.name)
  const contents = readFileSync(file)
  const params = {
    [constants.BROTLI_PARAM_QUALITY]: constants.BROTLI_MAX_QUALITY,
    [constants.BROTLI_PARAM_SIZE_HINT]: contents.length,
  }
  const compressed = { br: brotliCompressSync(contents, { params }), gz: gzipSync(contents, { level: 9 }) }
  for (const [extension, octets] of Object.entries(compressed)) {
    if (octets.length < contents.length) writeFileSync(`${file}.${extension}`, octets)
  }
}
