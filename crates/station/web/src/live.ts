// The live data of the station: one stream of server-sent events for all pages, and the samples of the last minutes.

import type { LivePlant, LiveState, Snapshot } from './api/types.ts'
import { changed, snapshotOf } from './lib/merge.ts'
import { bits } from './lib/series.ts'
import { currentQuality, SILENCE_MS } from './lib/stale.ts'
import { canView, onSessionChange, refreshSession } from './session.ts'
import { createStore, useStore } from './store.ts'

export interface RecentSample {
  at: number
  pa: number | null
  bits: number
}

/** Recent samples are kept for this long, at most one a second: the recorder writes with a delay, and not every sample. */
const KEPT_MS = 15 * 60_000
const STEP_MS = 1_000

/** Ages on the page are drawn this often while no snapshot arrives. */
const TICK_MS = 250

/** The state as the stream sends it; `null` until its first event. */
let state: LiveState | null = null
let snapshot: Snapshot | null = null
let receivedAt = 0
let openedAt = performance.now()
let stream: EventSource | null = null
const samples = new Map<string, RecentSample[]>()
/** Changes with every snapshot, and every tick without one. */
const changes = createStore(0)

export interface Live {
  /** The last snapshot that was received; `null` before the first. */
  snapshot: Snapshot | null
  /** Milliseconds since it was received, or since the stream was opened. */
  since: number
  connected: boolean
  /** The clock of the station. */
  now: number
}

export function live(): Live {
  const since = performance.now() - (snapshot ? receivedAt : openedAt)
  const now = snapshot ? Math.round(snapshot.station.now_ms + since) : Date.now()
  return { snapshot, since, connected: snapshot !== null && since < SILENCE_MS, now }
}

/** The samples of a series that were received since the page was opened. */
export function recentSamples(series: string): RecentSample[] {
  return samples.get(series) ?? []
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
    if (!stream) return
    const silent = performance.now() - Math.max(receivedAt, openedAt) > 2 * SILENCE_MS
    // The browser reconnects by itself, except after an HTTP error and on a connection that is only silent.
    if (stream.readyState === EventSource.CLOSED || silent) void reconnect()
    if (live().since > TICK_MS) notify()
  }, TICK_MS)
}

/** The stream may have ended because the session has. */
async function reconnect(): Promise<void> {
  connect()
  await refreshSession()
}

function connect(): void {
  stream?.close()
  openedAt = performance.now()
  stream = new EventSource('/api/live')
  // Each connection begins with the whole state, also when the browser connects again by itself.
  stream.addEventListener('snapshot', (event: MessageEvent<string>) => receive(JSON.parse(event.data) as LiveState))
  stream.addEventListener('change', (event: MessageEvent<string>) => {
    if (state)
      receive(changed(state, JSON.parse(event.data) as Partial<LiveState>, ['segments', 'gauges', 'standing_alarms']))
  })
  stream.addEventListener('error', () => void refreshSession())
}

/** Ends the stream and forgets its data: the next user may be another one. */
function disconnect(): void {
  stream?.close()
  stream = null
  state = null
  snapshot = null
  samples.clear()
  notify()
}

function receive(received: LiveState): void {
  const next = snapshotOf(received)
  // Without snapshots in between, the recent samples would show a line over the gap.
  if (snapshot && next.station.now_ms - snapshot.station.now_ms > 2 * SILENCE_MS) samples.clear()
  state = received
  snapshot = next
  receivedAt = performance.now()
  for (const gauge of next.gauges) {
    for (const reading of gauge.readings) {
      const quality = currentQuality(gauge, reading, 0)
      const pa = quality === 'stale' ? null : (reading.pa ?? reading.limit_pa)
      keep(reading.series, { at: next.station.now_ms, pa, bits: bits(quality) })
    }
  }
  notify()
}

function keep(series: string, sample: RecentSample): void {
  const kept = samples.get(series) ?? []
  const last = kept.at(-1)
  if (last && sample.at - last.at < STEP_MS && last.bits === sample.bits) return
  kept.push(sample)
  while (kept[0] && sample.at - kept[0].at > KEPT_MS) kept.shift()
  samples.set(series, kept)
}

function notify(): void {
  changes.set(changes.get() + 1)
}

/** The last snapshot. Only for pages: they are drawn after the first snapshot has been received. */
export function useSnapshot(): Snapshot {
  const { snapshot } = useLive()
  if (!snapshot) throw new Error('expected a snapshot, got none: pages are drawn after the first one')
  return snapshot
}

/** The reported states of valves and pumps; none without a connection, because they may have changed since. */
export function usePartStates(): LivePlant['states'] {
  const { connected } = useLive()
  const { plant } = useSnapshot()
  return connected ? plant.states : {}
}

/** Live data; the component is drawn again with every change. */
export function useLive(): Live {
  useStore(changes)
  return live()
}
