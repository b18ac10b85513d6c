// What the station shows now: one stream for all pages, with a memory of the last minutes.

import { useEffect, useReducer } from 'preact/hooks'
import type { Moment } from './api.ts'
import { bits } from './pure/series.ts'
import { SILENCE_MS, worth } from './pure/stale.ts'
import { isIn, onChange, whoami } from './session.ts'

export interface Seen {
  at: number
  pa: number | null
  bits: number
}

/** So long is remembered, at most one reading a second: what the record's dead band may hold back, and some more. */
const REMEMBERED_MS = 15 * 60_000
const STEP_MS = 1_000

/** How often ages are drawn again while nothing comes. */
const TICK_MS = 250

let moment: Moment | null = null
let heardAt = 0
let openedAt = performance.now()
let stream: EventSource | null = null
const tails = new Map<string, Seen[]>()
const listeners = new Set<() => void>()

export interface Live {
  /** The last moment that came; nothing before the first. */
  moment: Moment | null
  /** Milliseconds since it came, or since the page was opened. */
  since: number
  /** Whether the station is heard. */
  connected: boolean
  /** What the clock of the station shows. */
  now: number
}

export function live(): Live {
  const since = performance.now() - (moment ? heardAt : openedAt)
  const now = moment ? Math.round(moment.station.now_ms + since) : Date.now()
  return { moment, since, connected: moment !== null && since < SILENCE_MS, now }
}

/** What was seen of a series since the page was opened. */
export function tail(series: string): Seen[] {
  return tails.get(series) ?? []
}

/** Listens as long as the station lets us look. */
export function start(): void {
  onChange(() => {
    if (!isIn()) hangUp()
    else if (!stream) connect()
  })
  if (isIn()) connect()
  setInterval(() => {
    if (!stream) return
    const silent = performance.now() - Math.max(heardAt, openedAt) > 2 * SILENCE_MS
    // The browser tries again by itself, but not after an answer that is no stream, and not on a line that is only quiet.
    if (stream.readyState === EventSource.CLOSED || silent) void again()
    if (live().since > TICK_MS) tell()
  }, TICK_MS)
}

/** It may be that we may not look any more. */
async function again(): Promise<void> {
  connect()
  await whoami()
}

function connect(): void {
  stream?.close()
  openedAt = performance.now()
  stream = new EventSource('/api/live')
  stream.addEventListener('moment', (event: MessageEvent<string>) => take(JSON.parse(event.data) as Moment))
  // Asked at once: whoever has no session any more sees that before anything else.
  stream.addEventListener('error', () => void whoami())
}

/** What somebody saw is not for whoever comes next. */
function hangUp(): void {
  stream?.close()
  stream = null
  moment = null
  tails.clear()
  tell()
}

function take(next: Moment): void {
  // A gap in what we saw is a gap in what we draw.
  if (moment && next.station.now_ms - moment.station.now_ms > 2 * SILENCE_MS) tails.clear()
  moment = next
  heardAt = performance.now()
  for (const gauge of next.gauges) {
    for (const reading of gauge.readings) {
      const quality = worth(gauge, reading, 0)
      remember(reading.series, {
        at: next.station.now_ms,
        pa: quality === 'gap' ? null : reading.pa,
        bits: bits(quality),
      })
    }
  }
  tell()
}

function remember(series: string, seen: Seen): void {
  const kept = tails.get(series) ?? []
  const last = kept[kept.length - 1]
  if (last && seen.at - last.at < STEP_MS && last.bits === seen.bits) return
  kept.push(seen)
  while (kept[0] && seen.at - kept[0].at > REMEMBERED_MS) kept.shift()
  tails.set(series, kept)
}

function tell(): void {
  listeners.forEach((listener) => listener())
}

/** Draws the component again with every moment, and while none comes. */
export function useLive(): Live {
  const [, again] = useReducer((count: number) => count + 1, 0)
  useEffect(() => {
    const listener = (): void => again(undefined)
    listeners.add(listener)
    return () => void listeners.delete(listener)
  }, [])
  return live()
}
