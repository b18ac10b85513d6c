// A rate-of-rise measurement: its gauge, start, end and volume. The address of the page holds it, so it can be bookmarked.

import { type Range, rangeOf, rangeText } from '../../lib/range.ts'
import { setQuery, useLocation } from '../../router.tsx'
import { t } from '../../texts/texts.ts'

export interface Measurement {
  series: string
  begin: number | null
  /** `null` while the measurement goes on. */
  end: number | null
  /** The volume as typed. */
  litres: string
  /** How the indication depends on the gas. */
  gauge: GasDependence
  /** The accuracy of the gauge in percent, as typed. */
  accuracy: string
}

/** How the indication of a gauge depends on the gas, in the words of the API. */
export type GasDependence = 'none' | 'ionisation' | 'conduction'

const GAS_DEPENDENCES: GasDependence[] = ['none', 'ionisation', 'conduction']

/** The choices with their texts. */
export const gasDependences = (): [GasDependence, string][] =>
  GAS_DEPENDENCES.map((name) => [name, t.rise.gasDependences[name]])

export const gasDependence = (text: string | null): GasDependence =>
  GAS_DEPENDENCES.find((name) => name === text) ?? 'none'

/** The window before start and end are set. */
export const HOME: Range = { last: 30 * 60_000 }

/** The measurement in the address, and a function that changes it. */
export function useMeasurement(firstSeries: string): [Measurement, (measurement: Measurement) => void] {
  const { query } = useLocation()
  const time = (name: string): number | null => (query.get(name) ? Number(query.get(name)) : null)
  const measurement = {
    series: query.get('s') ?? firstSeries,
    begin: time('begin'),
    end: time('end'),
    litres: query.get('litres') ?? '',
    gauge: gasDependence(query.get('gauge')),
    accuracy: query.get('accuracy') ?? '',
  }
  const change = ({ series, begin, end, litres, gauge, accuracy }: Measurement): void => {
    const next = new URLSearchParams(query.has('range') || query.has('from') ? rangeText(rangeOf(query)) : {})
    next.set('s', series)
    if (begin !== null) next.set('begin', String(Math.round(begin)))
    if (end !== null) next.set('end', String(Math.round(end)))
    if (litres) next.set('litres', litres)
    if (gauge !== 'none') next.set('gauge', gauge)
    if (accuracy) next.set('accuracy', accuracy)
    setQuery(next)
  }
  return [measurement, change]
}

/** The measurement with a margin on both sides, as soon as start and end are set. */
export function windowAround({ begin, end }: Measurement, now: number): Range {
  if (begin === null || end === null) return HOME
  const margin = Math.max(5_000, (end - begin) * 0.25)
  return { from: begin - margin, to: Math.min(now, end + margin) }
}
