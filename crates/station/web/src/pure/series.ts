// Trends as a chart wants them: one rising list of times for all, a value or a gap for each series at each.

import type { Trend } from '../api.ts'

export const VALID = 1 << 0
export const OVER = 1 << 1
export const UNDER = 1 << 2
export const INVALID = 1 << 3
export const GAP = 1 << 4

/** A station that was switched off leaves no mark. While a gauge is recorded a sample is kept at least once a minute, so
 *  nothing for longer than this is a gap as well. */
const SILENCE_MS = 150_000

/** `null` is a gap, `undefined` is nothing at this time: a line goes through it. */
export type Value = number | null | undefined

export interface Curve {
  low: Value[]
  high: Value[]
  mean: Value[]
}

export interface Joined {
  /** Milliseconds, rising. */
  times: number[]
  curves: Curve[]
}

/** A stretch of time in which a gauge was beyond its range, or not valid. */
export interface Stretch {
  from: number
  to: number
  what: 'over' | 'under' | 'invalid'
  /** Where its range ends. */
  limit: number | null
}

/** Whether there was nothing but the end of a range: no place for a line. */
export function isBeyond(bits: number): boolean {
  return (bits & (OVER | UNDER)) !== 0 && (bits & VALID) === 0
}

/** A trend with an entry of nothing wherever a line must not go: in gaps, and beyond range. */
function broken(trend: Trend, binMs: number): Trend {
  const made: Trend = { series: trend.series, start_ms: [], low: [], high: [], mean: [], qualities: [] }
  const longest = Math.max(SILENCE_MS, 2.5 * binMs)
  trend.start_ms.forEach((start, place) => {
    const before = trend.start_ms[place - 1]
    const ended = ((trend.qualities[place - 1] ?? 0) & GAP) !== 0 && trend.mean[place - 1] !== null
    if (before !== undefined && (start - before > longest || (ended && start - before > 1.5 * binMs))) {
      push(made, before + Math.min(binMs, (start - before) / 2), null, null, null, GAP)
    }
    const bits = trend.qualities[place]!
    if (isBeyond(bits)) push(made, start, null, null, null, bits)
    else push(made, start, trend.low[place]!, trend.high[place]!, trend.mean[place]!, bits)
  })
  return made
}

function push(
  trend: Trend,
  at: number,
  low: number | null,
  high: number | null,
  mean: number | null,
  bits: number,
): void {
  trend.start_ms.push(at)
  trend.low.push(low)
  trend.high.push(high)
  trend.mean.push(mean)
  trend.qualities.push(bits)
}

/** All trends on one axis of time. `binMs` is how long a pixel is. */
export function join(trends: Trend[], binMs: number): Joined {
  const all = trends.map((trend) => broken(trend, binMs))
  const times = [...new Set(all.flatMap((trend) => trend.start_ms))].sort((one, two) => one - two)
  const places = new Map(times.map((time, place) => [time, place]))
  const curves = all.map((trend) => {
    const curve: Curve = { low: [], high: [], mean: [] }
    for (const list of Object.values(curve) as Value[][]) list.length = times.length
    trend.start_ms.forEach((start, at) => {
      const place = places.get(start)!
      curve.low[place] = trend.low[at]!
      curve.high[place] = trend.high[at]!
      curve.mean[place] = trend.mean[at]!
    })
    widen(curve)
    return curve
  })
  return { times, curves }
}

/** A gap reaches from the last value before it to the first after it, also at the times of other curves. */
function widen(curve: Curve): void {
  let before = -1
  let hasGap = false
  for (let place = 0; place <= curve.mean.length; place += 1) {
    const value = curve.mean[place]
    if (value === null) hasGap = true
    if (typeof value !== 'number' && place < curve.mean.length) continue
    for (let empty = before + 1; hasGap && empty < place; empty += 1) {
      curve.low[empty] = curve.high[empty] = curve.mean[empty] = null
    }
    before = place
    hasGap = false
  }
}

const STRETCHES: [number, Stretch['what']][] = [
  [OVER, 'over'],
  [UNDER, 'under'],
  [INVALID, 'invalid'],
]

/** Where a gauge was beyond its range or not valid. An entry holds until the next one, as a line does. */
export function stretches(trend: Trend, binMs: number): Stretch[] {
  const made: Stretch[] = []
  for (const [bit, what] of STRETCHES) {
    let open: Stretch | null = null
    trend.start_ms.forEach((start, place) => {
      if ((trend.qualities[place]! & bit) === 0) {
        open = null
        return
      }
      const next = trend.start_ms[place + 1] ?? start + binMs
      const to = next - start > Math.max(SILENCE_MS, 2.5 * binMs) ? start + binMs : next
      const limit = what === 'over' ? trend.high[place]! : what === 'under' ? trend.low[place]! : null
      if (open && start <= open.to) {
        open.to = to
        open.limit = farther(open, limit)
      } else made.push((open = { from: start, to, what, limit }))
    })
  }
  return made
}

/** The end of a range lies beyond everything that was measured within it. */
function farther({ what, limit }: Stretch, other: number | null): number | null {
  if (limit === null || other === null) return limit ?? other
  return what === 'over' ? Math.max(limit, other) : Math.min(limit, other)
}

/** A trend with what was seen since it was fetched: the record is a second late, and its dead band holds back more. */
export function withTail(trend: Trend, tail: { at: number; pa: number | null; bits: number }[]): Trend {
  const last = trend.start_ms[trend.start_ms.length - 1] ?? -Infinity
  const newer = tail.filter(({ at }) => at > last)
  const list = <T>(start: T[], end: T[]): T[] => start.concat(end)
  const values = newer.map(({ pa }) => pa)
  return {
    series: trend.series,
    start_ms: list(
      trend.start_ms,
      newer.map(({ at }) => at),
    ),
    low: list(trend.low, values),
    high: list(trend.high, values),
    mean: list(trend.mean, values),
    qualities: list(
      trend.qualities,
      newer.map(({ bits }) => bits),
    ),
  }
}

/** The bits of a quality, as a trend has them. */
export function bits(quality: string): number {
  return 1 << ['valid', 'overrange', 'underrange', 'invalid', 'gap'].indexOf(quality)
}

/** The place of the last known value at or before a time; -1 if there is none. */
export function placeAt(times: number[], at: number): number {
  let [low, high] = [0, times.length]
  while (low < high) {
    const middle = (low + high) >> 1
    if (times[middle]! <= at) low = middle + 1
    else high = middle
  }
  return low - 1
}

/** What a trend shows at a time: its value there, or nothing in a gap. */
export function valueAt(trend: Trend, at: number, binMs: number): { mean: number | null; bits: number } | null {
  const place = placeAt(trend.start_ms, at)
  const start = trend.start_ms[place]
  if (start === undefined || at - start > Math.max(SILENCE_MS, 2.5 * binMs)) return null
  const found = { mean: trend.mean[place]!, bits: trend.qualities[place]! }
  // After the pixel in which it fell silent there is nothing.
  return (found.bits & GAP) !== 0 && at - start > 1.5 * binMs ? { mean: null, bits: GAP } : found
}

/** Whole decades around all values; at least two of them. */
export function decades(low: number, high: number): [number, number] {
  if (!(low > 0) || !(high > 0)) return [1e-3, 1e3]
  let [from, to] = [Math.floor(Math.log10(low) - 0.05), Math.ceil(Math.log10(high) + 0.05)]
  if (to - from < 2) {
    if (Math.log10(low) - from < to - Math.log10(high)) from -= 1
    else to += 1
  }
  return [10 ** from, 10 ** to]
}
