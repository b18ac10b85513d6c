// The age of readings, and what it does to their quality.

import type { Gauge, Quality, Reading } from '../api/types.ts'

/** Without an event for this long the station counts as lost: it sends four a second. */
export const SILENCE_MS = 3_000

/** The age of the readings: the age that the station gave, plus the time since it gave it. */
export function ageOf(gauge: Gauge, sinceMs: number): number | null {
  return gauge.age_ms === null ? null : gauge.age_ms + Math.max(0, sinceMs)
}

export function isStale(gauge: Gauge, sinceMs: number): boolean {
  const age = ageOf(gauge, sinceMs)
  return age === null || age > gauge.stale_after_ms
}

/** The quality of a reading now: the last reading of a silent gauge is stale. */
export function currentQuality(gauge: Gauge, reading: Reading, sinceMs: number): Quality {
  return isStale(gauge, sinceMs) ? 'stale' : reading.quality
}
