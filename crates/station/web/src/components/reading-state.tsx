// The state of a gauge beside its readings: faults, and the age of the data.

import './reading-state.css'
import type { JSX } from 'preact'
import type { Gauge } from '../api/types.ts'
import { age, clock, day, moment } from '../lib/format.ts'
import { ageOf, isStale } from '../lib/stale.ts'
import type { Live } from '../live.ts'
import { t } from '../texts/texts.ts'

/** The reason why a gauge does not measure, and everything it reports. */
export function Faults({ gauge }: { gauge: Gauge }): JSX.Element | null {
  const sentences = [...(gauge.problem ? [gauge.problem] : []), ...gauge.exceptions]
  if (sentences.length + gauge.warnings.length === 0) return null
  return (
    <ul class="faults" lang="en">
      {sentences.map((sentence) => (
        <li key={sentence}>{sentence}</li>
      ))}
      {gauge.warnings.map((warning) => (
        <li class="muted" key={warning}>
          {warning}
        </li>
      ))}
    </ul>
  )
}

/** The age of the readings, or since when there are none. */
export function Age({ gauge, live }: { gauge: Gauge; live: Live }): JSX.Element {
  const ms = ageOf(gauge, live.since)
  if (ms === null) return <span class="age">{t.common.noDataYet}</span>
  if (!isStale(gauge, live.since)) return <span class="age">{ms < 1000 ? t.common.now : t.common.ago(age(ms))}</span>
  const since = live.now - ms
  const time = day(since) === day(live.now) ? clock(since) : moment(since)
  return <span class="age stale">{t.reading.noDataSince(time, age(ms))}</span>
}
