// The live data of all stations: one stream of server-sent events for all pages.

import { changed } from '../lib/merge.ts'
import { canView, onSessionChange, refreshSession } from '../session.ts'
import { createStore, useStore } from '../store.ts'
import type { State } from './types.ts'

/** Without an event for this long the archive counts as lost: it sends one a second. */
const SILENCE_MS = 6_000
const TICK_MS = 1_000

export interface Live {
  /** The last state that was received; `null` before the first. */
  state: State | null
  connected: boolean
  /** The clock of the archive. */
  now: number
}

let state: State | null = null
let receivedAt = performance.now()
let stream: EventSource | null = null
/** Changes with every event, and every tick without one. */
const changes = createStore(0)

export function live(): Live {
  const since = performance.now() - receivedAt
  return {
    state,
    connected: state !== null && since < SILENCE_MS,
    now: state ? Math.round(state.now_ms + since) : Date.now(),
  }
}

/** Receives live data while the session allows it. */
export function startLive(): void {
  onSessionChange(() => {
    if (!canView()) disconnect()
    else if (!stream) connect()
  })
  if (canView()) connect()
  // A page that the browser keeps for its back button would hold its connection, and a browser has six of them for all its windows.
  addEventListener('pagehide', () => {
    stream?.close()
    stream = null
  })
  addEventListener('pageshow', ({ persisted }) => {
    if (persisted && canView()) void reconnect()
  })
  setInterval(() => {
    const since = performance.now() - receivedAt
    // The browser reconnects by itself, except after an HTTP error and on a connection that is only silent.
    if (stream && (stream.readyState === EventSource.CLOSED || since > 2 * SILENCE_MS)) void reconnect()
    if (since > TICK_MS) notify()
  }, TICK_MS)
}

/** The stream may have ended because the session has. */
async function reconnect(): Promise<void> {
  connect()
  await refreshSession()
}

function connect(): void {
  stream?.close()
  receivedAt = performance.now()
  stream = new EventSource('/api/live')
  stream.addEventListener('snapshot', (event: MessageEvent<string>) => receive(JSON.parse(event.data) as State))
  stream.addEventListener('change', (event: MessageEvent<string>) => {
    const change = JSON.parse(event.data) as Partial<State>
    if (state) receive(changed(state, change, ['stations', 'readings', 'alarms']))
  })
  stream.addEventListener('error', () => void refreshSession())
}

/** Ends the stream and forgets its data: the next user may be another one. */
function disconnect(): void {
  stream?.close()
  stream = null
  state = null
  notify()
}

function receive(received: State): void {
  state = received
  receivedAt = performance.now()
  notify()
}

function notify(): void {
  changes.set(changes.get() + 1)
}

/** Live data; the component is drawn again with every change. */
export function useLive(): Live {
  useStore(changes)
  return live()
}

/** The last state. Only for pages: they are drawn after the first state has been received. */
export function useArchive(): State {
  const { state } = useLive()
  if (!state) throw new Error('expected a state, got none: pages are drawn after the first one')
  return state
}
