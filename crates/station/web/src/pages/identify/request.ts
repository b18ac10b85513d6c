// What the user chose and knows of a record. The address of the page holds it, so it can be bookmarked.

import type { PlantQuery, PumpDown, ReportQuery } from '../../api/types.ts'
import { momentOf } from '../../lib/format.ts'
import { UNITS, type Unit } from '../../lib/units.ts'
import { t } from '../../texts/texts.ts'
import { type GasDependence, gasDependence } from '../rise/measurement.ts'

/** All fields as typed. */
export interface PlantChoice {
  series: string
  /** The start of the chosen pump-down in ms; the last one without it. */
  run: string
  from: string
  to: string
  closed: string
  opened: string
  /** The volume in litres; without it a dose in mbar L and its time. */
  litres: string
  dose: string
  doseAt: string
  gauge: GasDependence
  /** In percent. */
  accuracy: string
  /** In the unit of the dashboard. */
  target: string
}

const FIELDS = ['run', 'from', 'to', 'closed', 'opened', 'litres', 'dose', 'doseAt', 'accuracy', 'target'] as const

export function choiceIn(query: URLSearchParams, firstSeries: string): PlantChoice {
  const fields = Object.fromEntries(FIELDS.map((name) => [name, query.get(name) ?? '']))
  return {
    ...(fields as Record<(typeof FIELDS)[number], string>),
    series: query.get('series') ?? firstSeries,
    gauge: gasDependence(query.get('gauge')),
  }
}

export function textOf(choice: PlantChoice): URLSearchParams {
  const text = new URLSearchParams({ series: choice.series })
  for (const name of FIELDS) if (choice[name]) text.set(name, choice[name])
  if (choice.gauge !== 'none') text.set('gauge', choice.gauge)
  return text
}

/** The request, or what is missing. */
export function queryOf(
  choice: PlantChoice,
  run: PumpDown | null,
  unit: Unit,
): { query: PlantQuery; problem: null } | { query: null; problem: string } {
  const from = momentOf(choice.from) ?? run?.start_ms
  const to = momentOf(choice.to) ?? run?.end_ms
  const missing = (problem: string): { query: null; problem: string } => ({ query: null, problem })
  if (from === undefined || to === undefined) return missing(t.identify.choosePumpDown)
  const volume = volumeOf(choice)
  if (!volume) return missing(t.identify.enterVolume)
  const time = (name: 'closed' | 'opened') => {
    const at = momentOf(choice[name])
    return at === null ? {} : { [name]: at }
  }
  const query = {
    series: choice.series,
    from,
    to,
    ...volume,
    ...time('closed'),
    ...time('opened'),
    gauge: choice.gauge,
    ...(choice.accuracy === '' ? {} : { accuracy: Number(choice.accuracy) / 100 }),
    ...(choice.target === '' ? {} : { target_pa: Number(choice.target) * UNITS[unit] }),
  }
  return { query, problem: null }
}

/** The same pump-down for a report. */
export function reported({ series, from, to, volume_m3, accuracy }: PlantQuery): ReportQuery {
  return {
    series,
    from,
    to,
    ...(volume_m3 ? { volume_m3 } : {}),
    ...(accuracy === undefined || accuracy === null ? {} : { accuracy }),
  }
}

function volumeOf({ litres, dose, doseAt }: PlantChoice): Partial<PlantQuery> | null {
  if (Number(litres) > 0) return { volume_m3: Number(litres) / 1000 }
  const at = momentOf(doseAt)
  // 1 mbar L is 0.1 Pa m³.
  return Number(dose) > 0 && at !== null ? { dose_pa_m3: Number(dose) / 10, dose_at: at } : null
}
