// The time with which the values of the list are compared.

import './reference.css'
import type { JSX } from 'preact'
import { fetchTrend } from '../../api/calls.ts'
import type { Trend } from '../../api/types.ts'
import { useQuery } from '../../components/hooks.ts'
import { age, moment } from '../../lib/format.ts'
import { BEFORE_MS, type Sample, sampleAt } from '../../lib/series.ts'

interface Props {
  reference: number | null
  /** The time of the values that are compared; `null` if there are none. */
  at: number | null
  set: (at: number | null) => void
}

export function Reference({ reference, at, set }: Props): JSX.Element {
  if (reference === null) {
    return (
      <p class="reference muted">
        Press in the chart to set a reference: the list then shows differences and slopes from there to the cursor.
      </p>
    )
  }
  return (
    <p class="reference">
      <strong>Reference {moment(reference)}</strong>
      <span class="muted">{at === null ? '' : distance(at - reference)}</span>
      <button type="button" onClick={() => set(null)}>
        Remove reference
      </button>
    </p>
  )
}

const distance = (ms: number): string =>
  ms < 0 ? `the values are ${age(-ms)} before it` : `the values are ${age(ms)} after it`

/** The samples that held at the reference, also when it is outside the window. */
export function useReferenceSamples(names: string[], reference: number | null): (series: string) => Sample | null {
  const key = `reference ${JSON.stringify([names, reference])}`
  const query = useQuery<Trend[]>(key, null, async (signal) => {
    if (reference === null) return []
    const from = reference - BEFORE_MS
    return Promise.all(names.map((name) => fetchTrend(name, from, reference + BIN_MS, BEFORE_MS / BIN_MS + 1, signal)))
  })
  return (series) => {
    const trend = query.value?.find((trend) => trend.series === series)
    return trend && reference !== null ? sampleAt(trend, reference, BIN_MS) : null
  }
}

/** The samples before a reference are fetched second by second. */
const BIN_MS = 1_000
