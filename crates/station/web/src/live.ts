// The live data of the station: one stream of server-sent events for all pages, and the samples of the last minutes.

import type { LivePlant, LiveState, Snapshot } from './api/types.ts'
import { changed } from './lib/changes.ts'
import { snapshotOf } from './lib/merge.ts'
import { bits } from './lib/series.ts'
import { currentQuality, SILENCE_MS } from './lib/stale.ts'
import type { FromHub } from './lib/stream-hub.ts'
import { canView, onSessionChange, refreshSession, sessionToken } from './session.ts'
import { sharedStream } from './shared-stream.ts'
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

/** The parts of the state whose entries a change names. */
const BY_NAME = ['segments', 'gauges', 'standing_alarms'] as const

/** Receives live data while the session allows it. */
export function startLive(): void {
  const stream = sharedStream({ silenceMs: 2 * SILENCE_MS, byName: [...BY_NAME] }, hear)
  const follow = (): void => {
    if (canView()) stream.join(sessionToken())
    else {
      stream.leave()
      forget()
    }
  }
  onSessionChange(follow)
  follow()
  setInterval(() => {
    if (canView() && live().since > TICK_MS) notify()
  }, TICK_MS)
}

function hear(message: FromHub): void {
  if (message.kind === 'ended') void refreshSession()
  else if (message.kind === 'snapshot') receive(JSON.parse(message.data) as LiveState, message.ageMs)
  else if (state) receive(changed(state, JSON.parse(message.data) as Partial<LiveState>, [...BY_NAME]))
}

/** Forgets the data: the next user may be another one. */
function forget(): void {
  if (!state) return
  state = null
  snapshot = null
  openedAt = performance.now()
  samples.clear()
  notify()
}

/** `ageMs`: how long ago another window received it. */
function receive(received: LiveState, ageMs = 0): void {
  const next = snapshotOf(received)
  // Without snapshots in between, the recent samples would show a line over the gap.
  if (snapshot && next.station.now_ms - snapshot.station.now_ms > 2 * SILENCE_MS) samples.clear()
  state = received
  snapshot = next
  receivedAt = performance.now() - ageMs
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

/** The clock of the station in whole seconds; the component is drawn again once a second. */
export const useSecond = (): number => useStore(changes, () => Math.floor(live().now / 1000) * 1000)

/** Live data; the component is drawn again with every change. */
export function useLive(): Live {
  useStore(changes)
  return live()
}
