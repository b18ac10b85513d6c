// The time that a chart shows.

/** The last milliseconds, moving with the time; or a fixed window. */
export type Range = { last: number } | { from: number; to: number }

const MINUTE = 60_000

/** The texts of their buttons are `t.trends.spans[name]`. */
export const SPANS = [
  { name: '1m', ms: MINUTE },
  { name: '10m', ms: 10 * MINUTE },
  { name: '1h', ms: 60 * MINUTE },
  { name: '1d', ms: 1_440 * MINUTE },
  { name: '1w', ms: 10_080 * MINUTE },
] as const

export const DEFAULT_RANGE = { last: 60 * MINUTE }

/** The spans of a recording that has just begun. */
const FITTING_MS = [20, 40, 60, 120, 300, 600, 1200, 1800, 3600].map((seconds) => seconds * 1_000)

/** The beginning of a recording is searched this often. */
export const SEARCH_MS = 10_000

/** The shortest span that shows everything that was recorded since `first` until it is searched again, at most `longest`. */
export function fittingSpan(first: number | null, now: number, longest: number): number {
  const needed = now - (first ?? now) + SEARCH_MS
  return Math.min(longest, FITTING_MS.find((ms) => needed <= ms) ?? longest)
}

/** The same as a range of at most an hour. */
export const fittingRange = (first: number | null, now: number): Range => ({
  last: fittingSpan(first, now, DEFAULT_RANGE.last),
})

/** The shortest and the longest window. */
export const SHORTEST_MS = 2_000
const LONGEST_MS = 20 * 365 * 1_440 * MINUTE

export function isLive(range: Range): range is { last: number } {
  return 'last' in range
}

export function windowOf(range: Range, now: number): [number, number] {
  return isLive(range) ? [now - range.last, now] : [range.from, range.to]
}

/** A constant pressure is recorded once a minute, so the next sample may lie this far outside a window. */
const OUTSIDE_MS = 90_000

/** Below this pixel length the recorder draws single samples. */
const SAMPLES_MS = 10_000

/** The station accepts at most 20000 pixels. */
const MOST_BINS = 15_000

export interface Bins {
  from: number
  to: number
  binMs: number
  count: number
}

/**
 * The pixels to fetch for a window. They lie on multiples of their length, so they do not move with the time, and they reach
 * beyond the window, so lines go to its edges.
 */
export function aligned([from, to]: [number, number], pixels: number): Bins {
  const fine = Math.ceil((to - from) / pixels)
  const outside = fine < SAMPLES_MS ? OUTSIDE_MS : fine
  const binMs = Math.max(1, fine, Math.ceil((to - from + 2 * outside) / MOST_BINS))
  const start = Math.floor((from - outside) / binMs) * binMs
  const count = Math.ceil((to + outside - start) / binMs)
  return { from: start, to: start + count * binMs, binMs, count }
}

/** Zooms in (factor below 1) or out around the time `at`, which keeps its place. */
export function zoomed([from, to]: [number, number], at: number, factor: number): Range {
  const span = Math.min(LONGEST_MS, Math.max(SHORTEST_MS, (to - from) * factor))
  const start = Math.round(at - ((at - from) / (to - from)) * span)
  return { from: start, to: Math.round(start + span) }
}

export function moved([from, to]: [number, number], part: number): Range {
  const by = Math.round((to - from) * part)
  return { from: from + by, to: to + by }
}

/** A live range stands still, and a fixed one becomes the shortest live one that is as long. */
export function toggled(range: Range, now: number): Range {
  if (isLive(range)) return { from: Math.round(now - range.last), to: Math.round(now) }
  const longest = SPANS[SPANS.length - 1] as (typeof SPANS)[number]
  return { last: (SPANS.find(({ ms }) => ms >= range.to - range.from) ?? longest).ms }
}

/** The range in the address of a page. */
export function rangeText(range: Range): Record<string, string> {
  if (!isLive(range)) return { from: String(range.from), to: String(range.to) }
  return { range: SPANS.find(({ ms }) => ms === range.last)?.name ?? `${range.last}ms` }
}

/** The range in the address; `usual` if it has none. */
export function rangeOf(query: URLSearchParams, usual: Range = DEFAULT_RANGE): Range {
  const [from, to] = [Number(query.get('from')), Number(query.get('to'))]
  if (query.has('from') && Number.isFinite(from) && Number.isFinite(to) && to - from >= SHORTEST_MS) return { from, to }
  const named = SPANS.find(({ name }) => name === query.get('range'))
  return named ? { last: named.ms } : usual
}

const SECOND = 1_000
const HOUR = 60 * MINUTE
const DAY = 24 * HOUR

/** The steps between rows of a data table. */
const STEPS = [
  ...[1, 2, 5, 10, 15, 30].map((count) => count * SECOND),
  ...[1, 2, 5, 10, 15, 30].map((count) => count * MINUTE),
  ...[1, 2, 3, 6, 12].map((count) => count * HOUR),
  ...[1, 2, 7, 14, 30].map((count) => count * DAY),
]

/** Round times in a window for a data table, the latest first; at most `most`. */
export function tableTimes([from, to]: [number, number], most: number): number[] {
  const least = (to - from) / most
  const step = STEPS.find((step) => step >= least) ?? Math.ceil(least / DAY) * DAY
  const last = Math.floor(to / step) * step
  const count = Math.max(0, Math.floor((last - from) / step) + 1)
  return Array.from({ length: count }, (_, index) => last - index * step)
}
