// The end of the live stream in a window: the stream itself is held by a worker that all windows share, or by the window where the browser
// has no such worker.

import { CHECK_MS, createHub, type FromHub, type Member, type StreamOptions, type ToHub } from './lib/stream-hub.ts'

export interface SharedStream {
  /** Receives data for this session; nothing changes if it does so already. */
  join: (session: string) => void
  leave: () => void
}

type Link = (message: ToHub) => void

/** The hub says something at least once in this many times of silence, also if the station is lost. Otherwise the worker has ended. */
const PATIENCE = 4

export function sharedStream(options: StreamOptions, receive: (message: FromHub) => void): SharedStream {
  let link: Link | null = null
  let drop = (): void => {}
  let session: string | null = null
  let heardAt = 0
  let hasWorker = typeof SharedWorker !== 'undefined'

  const hear: Member = (message) => {
    heardAt = performance.now()
    if (session !== null) receive(message)
  }
  const toWorker = (): Link => {
    // Vite finds the worker by this expression.
    const worker = new SharedWorker(new URL('./stream-worker.ts', import.meta.url), { type: 'module' })
    const { port } = worker
    port.onmessage = ({ data }: MessageEvent<FromHub>) => hear(data)
    worker.onerror = () => {
      hasWorker = false
      relink()
    }
    drop = () => {
      worker.onerror = null
      port.onmessage = null
      port.postMessage({ kind: 'leave' })
      port.close()
    }
    return (message) => port.postMessage(message)
  }
  const toOwn = (): Link => {
    const hub = createHub(
      options,
      () => new EventSource('/api/live'),
      () => performance.now(),
    )
    const timer = setInterval(hub.check, CHECK_MS)
    drop = () => {
      clearInterval(timer)
      hub.leave(hear)
    }
    return (message) => (message.kind === 'join' ? hub.join(hear, message.session) : hub.leave(hear))
  }
  const newLink = (): Link => {
    try {
      if (hasWorker) return toWorker()
    } catch {
      // The browser refuses, for example a private window.
      hasWorker = false
    }
    return toOwn()
  }
  const send = (): void => {
    if (session === null) return
    heardAt = performance.now()
    link ??= newLink()
    link({ kind: 'join', session, options })
  }
  const relink = (): void => {
    drop()
    link = null
    send()
  }
  const pause = (): void => {
    if (session !== null) link?.({ kind: 'leave' })
  }
  const comeBack = (): void => {
    send()
    // Another user may have logged in meanwhile: the stream would be that of the new session, and the page would name the former user.
    receive({ kind: 'ended' })
  }

  // A page that the browser keeps for its back button, or freezes, reads no messages: they would pile up, and the stream would stay open.
  addEventListener('pagehide', pause)
  document.addEventListener('freeze', pause)
  addEventListener('pageshow', ({ persisted }) => persisted && comeBack())
  document.addEventListener('resume', comeBack)
  setInterval(() => {
    if (session !== null && performance.now() - heardAt > PATIENCE * options.silenceMs) relink()
  }, options.silenceMs)

  return {
    join: (by) => {
      if (by === session) return
      session = by
      send()
    },
    leave: () => {
      pause()
      session = null
    },
  }
}
