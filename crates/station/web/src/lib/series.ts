// Trends for a chart: one rising list of times, and for each series a value or a gap at each time.

import type { Quality, Trend } from '../api/types.ts'

export const VALID = 1 << 0
export const OVER = 1 << 1
export const UNDER = 1 << 2
export const FAULT = 1 << 3
export const GAP = 1 << 4
export const OFF = 1 << 5
export const MISSING = 1 << 6
export const ASSUMED = 1 << 7

/**
 * No sample for longer than this is a gap: a gauge is recorded at least once a minute, and a station that is switched off
 * records no mark.
 */
const LONGEST_MS = 150_000

/** The sample that holds at a time is at most this much earlier. */
export const BEFORE_MS = LONGEST_MS

/** `null` is a gap; `undefined` is no sample at this time, and the line goes on. */
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

/** The gauge shows the same value within this part of it: 0.002 decades, the deadband of the recorder. */
const SAME = 0.0046

/** A time in which a gauge was outside its range, off, reported a fault, or was not recorded. */
export interface Stretch {
  from: number
  to: number
  kind: 'over' | 'under' | 'fault' | 'off' | 'missing' | 'assumed' | 'none'
  /** The end of the range. */
  limit: number | null
}

/** Whether two values differ by more than the deadband: between them the recorder left out no slope, so the first one was held. */
function isJump(one: number, other: number | null): boolean {
  return other === null || Math.abs(one - other) > SAME * Math.max(Math.abs(one), Math.abs(other))
}

/** The end of the range where the gauge was beyond it in the pixel; above the range first. */
function boundAt({ low, high, qualities }: Trend, index: number): number | null {
  const bits = qualities[index] ?? 0
  return (bits & OVER ? high[index] : bits & UNDER ? low[index] : null) ?? null
}

/** All values of a trend that a chart shows: means, and the ends of ranges. */
export function valuesOf(trend: Trend): (number | null)[] {
  return trend.mean.flatMap((mean, index) => [mean, boundAt(trend, index)])
}

/** Whether the gauge was outside its range all the time: no line is drawn. */
export function isOutside(bits: number): boolean {
  return (bits & (OVER | UNDER)) !== 0 && (bits & VALID) === 0
}

/** Whether the data ended in a pixel. One with a last value had a gap before it. */
function endsInGap({ qualities, last }: Trend, index: number): boolean {
  return ((qualities[index] ?? 0) & GAP) !== 0 && (last[index] ?? null) === null
}

/** Whether there are no data between a sample and the next one: it is distant, or the data ended in the pixel of the sample. */
function isGap(trend: Trend, index: number, next: number, binMs: number): boolean {
  const time = next - (trend.start_ms[index] ?? next)
  const hasEnded = endsInGap(trend, index) && time > 1.5 * binMs
  return hasEnded || time > Math.max(LONGEST_MS, 2.5 * binMs)
}

/** Whether the gauge left its range, or failed, in a pixel and had not measured again when it ended. Spans do not tell it. */
function endsOutside({ qualities, last }: Trend, index: number, hasLast: boolean): boolean {
  return hasLast && (last[index] ?? null) === null && ((qualities[index] ?? 0) & ~(VALID | GAP)) !== 0
}

/**
 * A trend with a gap wherever the line must break: between distant samples, and outside the range. Between two pixels without a gap the
 * last value of the first one is held: a straight line to the mean of the second one would be a slope that was never measured.
 */
function withGaps(trend: Trend, binMs: number): Trend {
  const made: Trend = { series: trend.series, start_ms: [], low: [], high: [], mean: [], last: [], qualities: [] }
  const hasLast = trend.last.some((value) => value !== null)
  trend.start_ms.forEach((start, index) => {
    const before = trend.start_ms[index - 1]
    const isDrawn = before !== undefined && (trend.mean[index - 1] ?? null) !== null
    if (isDrawn && isGap(trend, index - 1, start, binMs)) {
      push(made, before + Math.min(binMs, (start - before) / 2), null, null, null, GAP)
    } else if (isDrawn && start - before > 1.5 * binMs && endsOutside(trend, index - 1, hasLast)) {
      push(made, before + binMs, null, null, null, trend.qualities[index - 1]!)
    } else if (isDrawn) {
      hold(made, trend, index, binMs)
    }
    const bits = trend.qualities[index]!
    if (isOutside(bits)) push(made, start, null, null, null, bits)
    else push(made, start, trend.low[index]!, trend.high[index]!, trend.mean[index]!, bits)
  })
  return made
}

/** Holds the last value of the pixel before `index` where the curve would be another one. */
function hold(made: Trend, trend: Trend, index: number, binMs: number): void {
  const held = trend.last[index - 1] ?? null
  const [before, start] = [trend.start_ms[index - 1]!, trend.start_ms[index]!]
  if (held === null || start - before <= 1.5 * binMs) return
  // A pixel has a mean of the values before and after a jump.
  if (isJump(held, trend.mean[index - 1]!)) push(made, before + binMs, held, held, held, VALID)
  if (isJump(held, trend.mean[index] ?? null)) push(made, start - 1, held, held, held, VALID)
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
  trend.last.push(mean)
  trend.qualities.push(bits)
}

/** All trends on one time axis. `binMs` is the length of a pixel. */
export function join(trends: Trend[], binMs: number): Joined {
  const all = trends.map((trend) => withGaps(trend, binMs))
  const times = [...new Set(all.flatMap((trend) => trend.start_ms))].sort((one, two) => one - two)
  const indices = new Map(times.map((time, index) => [time, index]))
  const curves = all.map((trend) => {
    const curve: Curve = { low: [], high: [], mean: [] }
    for (const list of Object.values(curve) as Value[][]) list.length = times.length
    trend.start_ms.forEach((start, at) => {
      const index = indices.get(start)!
      curve.low[index] = trend.low[at]!
      curve.high[index] = trend.high[at]!
      curve.mean[index] = trend.mean[at]!
    })
    widen(curve)
    return curve
  })
  return { times, curves }
}

/** A gap reaches from the last value before it to the first after it, also at the times of the other curves. */
function widen(curve: Curve): void {
  let before = -1
  let hasGap = false
  for (let index = 0; index <= curve.mean.length; index += 1) {
    const value = curve.mean[index]
    if (value === null) hasGap = true
    if (typeof value !== 'number' && index < curve.mean.length) continue
    for (let empty = before + 1; hasGap && empty < index; empty += 1) {
      curve.low[empty] = curve.high[empty] = curve.mean[empty] = null
    }
    before = index
    hasGap = false
  }
}

const STRETCHES: [number, Stretch['kind']][] = [
  [OVER, 'over'],
  [UNDER, 'under'],
  [FAULT, 'fault'],
  [OFF, 'off'],
  [MISSING, 'missing'],
  [ASSUMED, 'assumed'],
]

/** The times in which a gauge was outside its range, off, or reported a fault. A sample holds until the next one, or until a gap begins. */
export function stretches(trend: Trend, binMs: number): Stretch[] {
  const made: Stretch[] = []
  for (const [bit, kind] of STRETCHES) {
    let open: Stretch | null = null
    trend.start_ms.forEach((start, index) => {
      if ((trend.qualities[index]! & bit) === 0) {
        open = null
        return
      }
      const next = trend.start_ms[index + 1] ?? start + binMs
      // A pixel with a last value ends within the range.
      const isOver = isGap(trend, index, next, binMs) || (trend.last[index] ?? null) !== null
      const to = isOver ? Math.min(next, start + binMs) : next
      const limit = kind === 'over' ? trend.high[index]! : kind === 'under' ? trend.low[index]! : null
      if (open && start <= open.to) {
        open.to = to
        open.limit = outer(open, limit)
      } else {
        open = { from: start, to, kind, limit }
        made.push(open)
      }
    })
  }
  return made
}

/** The times of a window without data: before the first sample, between samples, and after the last one. */
export function withoutData(trend: Trend, binMs: number, [from, until]: [number, number]): Stretch[] {
  const made: Stretch[] = []
  const { start_ms, qualities } = trend
  const first = start_ms[0] ?? until
  let open = first - from > Math.max(LONGEST_MS, 2.5 * binMs) ? from : null
  const close = (to: number): void => {
    if (open !== null && to > open) made.push({ from: open, to, kind: 'none', limit: null })
    open = null
  }
  start_ms.forEach((start, index) => {
    // A mark that there are no data, and not the last data of a pixel.
    if (qualities[index] === GAP) {
      open ??= start
      return
    }
    close(start)
    const next = start_ms[index + 1] ?? until
    if (isGap(trend, index, next, binMs)) open = start + Math.min(binMs, (next - start) / 2)
  })
  close(until)
  return made
}

/** Of two ends of a range the outer one: measured values lie within the range. */
function outer({ kind, limit }: Stretch, other: number | null): number | null {
  if (limit === null || other === null) return limit ?? other
  return kind === 'over' ? Math.max(limit, other) : Math.min(limit, other)
}

/**
 * A trend with the samples that were received since it was fetched. The recorder writes a second late, and not every sample:
 * its deadband leaves some out.
 */
export function withRecent(trend: Trend, recent: { at: number; pa: number | null; bits: number }[]): Trend {
  const last = trend.start_ms.at(-1) ?? -Infinity
  const newer = recent.filter(({ at }) => at > last)
  const values = newer.map(({ pa }) => pa)
  return {
    series: trend.series,
    start_ms: [...trend.start_ms, ...newer.map(({ at }) => at)],
    low: [...trend.low, ...values],
    high: [...trend.high, ...values],
    mean: [...trend.mean, ...values],
    // Each of these samples holds for a second.
    last: [...trend.last, ...newer.map(() => null)],
    qualities: [...trend.qualities, ...newer.map(({ bits }) => bits)],
  }
}

/** The bit of a quality in a trend. */
export function bits(quality: Quality): number {
  return 1 << ['valid', 'overrange', 'underrange', 'fault', 'stale', 'off', 'missing', 'assumed'].indexOf(quality)
}

/** The index of the last time at or before `at`; -1 if there is none. */
export function indexAt(times: number[], at: number): number {
  let [low, high] = [0, times.length]
  while (low < high) {
    const middle = (low + high) >> 1
    if (times[middle]! <= at) low = middle + 1
    else high = middle
  }
  return low - 1
}

export interface Sample {
  /** The mean of the measured values; beyond the range the end of the range. */
  mean: number | null
  /** The qualities that occurred. */
  bits: number
}

/** The sample of a trend that holds at a time; `null` where there is none. */
export function sampleAt(trend: Trend, at: number, binMs: number): Sample | null {
  const index = indexAt(trend.start_ms, at)
  const start = trend.start_ms[index]
  if (start === undefined || at - start > Math.max(LONGEST_MS, 2.5 * binMs)) return null
  const held = trend.last[index] ?? null
  if (held !== null && at - start >= binMs) return { mean: held, bits: VALID }
  const found = { mean: boundAt(trend, index) ?? trend.mean[index]!, bits: trend.qualities[index]! }
  // A gap begins after its pixel.
  return endsInGap(trend, index) && at - start > 1.5 * binMs ? { mean: null, bits: GAP } : found
}

/** The quality of a sample: the worst that applies to its mean. */
export function qualityOf({ bits, mean }: Sample): Quality {
  if (bits & OVER) return 'overrange'
  if (bits & UNDER) return 'underrange'
  if (mean !== null) return 'valid'
  if (bits & FAULT) return 'fault'
  if (bits & OFF) return 'off'
  if (bits & MISSING) return 'missing'
  return bits & ASSUMED ? 'assumed' : 'stale'
}

/** Whole decades around all values, at least two. */
export function decades(low: number, high: number): [number, number] {
  if (!(low > 0) || !(high > 0)) return [1e-3, 1e3]
  let [from, to] = [Math.floor(Math.log10(low) - 0.05), Math.ceil(Math.log10(high) + 0.05)]
  if (to - from < 2) {
    if (Math.log10(low) - from < to - Math.log10(high)) from -= 1
    else to += 1
  }
  return [10 ** from, 10 ** to]
}
