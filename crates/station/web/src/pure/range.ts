// Which time a chart shows: the last so many milliseconds, moving on, or a window that stands.

export type Range = { last: number } | { from: number; to: number }

const MINUTE = 60_000

export const SPANS: { name: string; words: string; ms: number }[] = [
  { name: '10m', words: '10 min', ms: 10 * MINUTE },
  { name: '1h', words: '1 hour', ms: 60 * MINUTE },
  { name: '1d', words: '1 day', ms: 1_440 * MINUTE },
  { name: '1w', words: '1 week', ms: 10_080 * MINUTE },
]

/** The shortest and the longest time that can be looked at. */
const SHORTEST = 2_000
const LONGEST = 20 * 365 * 1_440 * MINUTE

export function isLive(range: Range): range is { last: number } {
  return 'last' in range
}

export function windowOf(range: Range, now: number): [number, number] {
  return isLive(range) ? [now - range.last, now] : [range.from, range.to]
}

/** While nothing moves a sample is kept once a minute: so far outside of a window lies the next one, and some more. */
const OUTSIDE_MS = 90_000

/** A level of the record is coarser than this; below it single samples are drawn. */
const SAMPLES_MS = 10_000

/** The station draws at most 20000 pixels. */
const MOST_BINS = 15_000

export interface Bins {
  from: number
  to: number
  binMs: number
  count: number
}

/** What is to be fetched for a window: pixels that stay where they are while time goes on, and as much on both sides that
 *  lines go to the edges. */
export function aligned([from, to]: [number, number], pixels: number): Bins {
  const fine = Math.ceil((to - from) / pixels)
  const outside = fine < SAMPLES_MS ? OUTSIDE_MS : fine
  const binMs = Math.max(1, fine, Math.ceil((to - from + 2 * outside) / MOST_BINS))
  const start = Math.floor((from - outside) / binMs) * binMs
  const count = Math.ceil((to + outside - start) / binMs)
  return { from: start, to: start + count * binMs, binMs, count }
}

/** Closer (factor below 1) or farther, so that what lies at `at` stays where it is. */
export function zoomed([from, to]: [number, number], at: number, factor: number): Range {
  const span = Math.min(LONGEST, Math.max(SHORTEST, (to - from) * factor))
  const start = Math.round(at - ((at - from) / (to - from)) * span)
  return { from: start, to: Math.round(start + span) }
}

export function moved([from, to]: [number, number], part: number): Range {
  const by = Math.round((to - from) * part)
  return { from: from + by, to: to + by }
}

/** As it stands in the address of the page. */
export function rangeText(range: Range): Record<string, string> {
  if (!isLive(range)) return { from: String(range.from), to: String(range.to) }
  return { range: SPANS.find(({ ms }) => ms === range.last)?.name ?? `${range.last}ms` }
}

export function rangeOf(query: URLSearchParams): Range {
  const [from, to] = [Number(query.get('from')), Number(query.get('to'))]
  if (query.has('from') && Number.isFinite(from) && Number.isFinite(to) && to - from >= SHORTEST) return { from, to }
  const named = SPANS.find(({ name }) => name === query.get('range'))
  return { last: named?.ms ?? SPANS[1]!.ms }
}
