// The worker that all windows of a browser share: it holds the live stream for them.

import { CHECK_MS, createHub, type FromHub, type Hub, type Member, type ToHub } from './lib/stream-hub.ts'

let hub: Hub | null = null

addEventListener('connect', (event) => {
  const [port] = (event as MessageEvent).ports
  if (!port) return
  const member: Member = (message: FromHub) => port.postMessage(message)
  port.onmessage = ({ data }: MessageEvent<ToHub>) => {
    if (data.kind === 'leave') hub?.leave(member)
    else {
      hub ??= createHub(
        data.options,
        () => new EventSource('/api/live'),
        () => performance.now(),
      )
      hub.join(member, data.session)
    }
  }
})

setInterval(() => hub?.check(), CHECK_MS)
