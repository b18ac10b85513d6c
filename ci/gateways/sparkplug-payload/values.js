// The values of Sparkplug payloads as a host reads them that keeps no births: one payload in base64 a line; prints a JSON object a line.
import sparkplug from 'sparkplug-payload'
import { createInterface } from 'node:readline'

const { decodePayload } = sparkplug.get('spBv1.0')
for await (const line of createInterface({ input: process.stdin })) {
  const metrics = decodePayload(Buffer.from(line, 'base64')).metrics ?? []
  // Numbers of 64 bits are objects of the library.
  const plain = value => (value && typeof value === 'object' && 'toNumber' in value ? value.toNumber() : value)
  console.log(JSON.stringify(Object.fromEntries(metrics.map(({ name, value }) => [name, plain(value)]))))
}
