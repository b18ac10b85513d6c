// The series and the time that the trends page shows. The address of the page holds them.

import { type Range, rangeOf, rangeText } from '../../lib/range.ts'
import { setQuery, useLocation } from '../../router.tsx'

export interface TrendChoice {
  series: string[]
  range: Range
  /** Whether the pressure axis has all decades. */
  isAllDecades: boolean
}

/** The number of series that are shown before the user has chosen. */
const FIRST_SERIES = 4

/** The choice in the address, and a function that changes it. */
export function useTrendChoice(names: string[]): [TrendChoice, (change: Partial<TrendChoice>) => void] {
  const { query } = useLocation()
  const named = query.getAll('s').filter((name) => names.includes(name))
  const choice = {
    series: query.has('s') || query.has('none') ? named : names.slice(0, FIRST_SERIES),
    range: rangeOf(query),
    isAllDecades: query.has('whole'),
  }
  const change = (changed: Partial<TrendChoice>): void => {
    const { series, range, isAllDecades } = { ...choice, ...changed }
    const next = new URLSearchParams(rangeText(range))
    for (const name of series) next.append('s', name)
    if (series.length === 0) next.set('none', '')
    if (isAllDecades) next.set('whole', '')
    setQuery(next)
  }
  return [choice, change]
}
