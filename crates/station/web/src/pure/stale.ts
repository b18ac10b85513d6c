// What may be believed of a gauge, and what must be shown as old.

import type { Gauge, Quality, Reading } from '../api.ts'

/** Readings older than so many polls are stale, and never sooner than after so many milliseconds. free choice. */
const POLLS = 5
const LEAST_MS = 3_000

/** After so long without a moment the station counts as lost, however the connection looks: it sends four in a second. */
export const SILENCE_MS = 3_000

/** How old the readings are: as the station said, and the time since it said so. */
export function ageOf(gauge: Gauge, sinceMs: number): number | null {
  return gauge.age_ms === null ? null : gauge.age_ms + Math.max(0, sinceMs)
}

export function isStale(gauge: Gauge, sinceMs: number): boolean {
  const age = ageOf(gauge, sinceMs)
  return age === null || age > Math.max(POLLS * gauge.poll_ms, LEAST_MS)
}

/** What a reading is worth to somebody who looks now: an old one is a gap, whatever it was. */
export function worth(gauge: Gauge, reading: Reading, sinceMs: number): Quality {
  return isStale(gauge, sinceMs) ? 'gap' : reading.quality
}
