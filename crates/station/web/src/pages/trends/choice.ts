// The series and the time that the trends page shows. The address of the page holds them.

import { fetchTrend } from '../../api/calls.ts'
import { useQuery } from '../../components/hooks.ts'
import { DEFAULT_RANGE, fittingRange, type Range, rangeOf, rangeText, SEARCH_MS } from '../../lib/range.ts'
import { live } from '../../live.ts'
import { setQuery, useLocation } from '../../router.tsx'

export interface TrendChoice {
  series: string[]
  /** The points of slaves, by their keys. */
  points: string[]
  range: Range
  /** Whether the pressure axis has all decades. */
  isAllDecades: boolean
  /** The time with which the values are compared. */
  reference: number | null
}

/** The number of series that are shown before the user has chosen. */
const FIRST_SERIES = 4

/** The choice in the address, and a function that changes it. */
export function useTrendChoice(
  names: string[],
  keys: string[] = [],
): [TrendChoice, (change: Partial<TrendChoice>) => void] {
  const { query } = useLocation()
  const usual = useUsualRange(names)
  const named = query.getAll('s').filter((name) => names.includes(name))
  const choice = {
    series: query.has('s') || query.has('none') ? named : names.slice(0, FIRST_SERIES),
    points: keys.filter((key) => query.getAll('p').includes(key)),
    range: rangeOf(query, usual),
    isAllDecades: query.has('whole'),
    reference: momentIn(query.get('reference')),
  }
  const change = (changed: Partial<TrendChoice>): void => {
    const { series, points, range, isAllDecades, reference } = { ...choice, ...changed }
    const next = new URLSearchParams(rangeText(range))
    for (const name of series) next.append('s', name)
    if (series.length === 0) next.set('none', '')
    for (const key of points) next.append('p', key)
    if (isAllDecades) next.set('whole', '')
    if (reference !== null) next.set('reference', String(reference))
    setQuery(next)
  }
  return [choice, change]
}

/** A time in the address, in milliseconds. */
function momentIn(text: string | null): number | null {
  return text !== null && /^\d{1,15}$/.test(text) ? Number(text) : null
}

/** The number of pixels in which the beginning of a recording is searched. */
const PIXELS = 360

/** The range without a choice of the user: everything of a recording that has just begun, otherwise an hour. */
function useUsualRange(names: string[]): Range {
  const first = useQuery('first sample', SEARCH_MS, async (signal) => {
    const now = Math.round(live().now)
    const series = names.slice(0, FIRST_SERIES)
    const from = now - DEFAULT_RANGE.last
    const trends = await Promise.all(series.map((name) => fetchTrend(name, from, now, PIXELS, signal)))
    const starts = trends.flatMap(({ start_ms }) => start_ms.slice(0, 1))
    return { range: fittingRange(starts.length ? Math.min(...starts) : null, now) }
  })
  return first.value?.range ?? DEFAULT_RANGE
}
