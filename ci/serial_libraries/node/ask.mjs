// Asks the station at address 5 for its status through serialport of npm, as a program of a user does.
//
// Usage: node ask.mjs PORT
//
// The port is opened once, with 19200 bit/s and even parity. Prints the answer in hex.

import { SerialPort } from 'serialport'

// FDL status request of master 2, and the length of its answer (profibus-wire 1.9).
const REQUEST = Buffer.from('100502495016', 'hex')
const ANSWER_OCTETS = 6

// The longest wait for an answer in ms: a loaded computer is slow.
const TIMEOUT_MS = 60_000

function failed(reason) {
  console.error(reason)
  process.exit(1)
}

const port = new SerialPort({ path: process.argv[2], baudRate: 19200, dataBits: 8, parity: 'even', stopBits: 1 })
const timer = setTimeout(() => failed('no answer'), TIMEOUT_MS)
let answer = Buffer.alloc(0)

port.on('error', failed)
port.on('open', () => port.write(REQUEST))
port.on('data', (octets) => {
  answer = Buffer.concat([answer, octets])
  if (answer.length >= ANSWER_OCTETS) {
    clearTimeout(timer)
    console.log(answer.toString('hex').match(/../g).join(' '))
    port.close()
  }
})
