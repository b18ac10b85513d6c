// The bus status of a gauge or another station, as a symbol and a word.

import './bus-status.css'
import type { JSX } from 'preact'
import type { BusStatus, Gauge } from '../api/types.ts'
import { t } from '../texts/texts.ts'

/** `stale` shows the status as old: it is the last one that is known. */
export function BusStatusMark({ status, stale = false }: { status: BusStatus; stale?: boolean }): JSX.Element {
  const { label, sentence } = t.busStatus[status]
  return (
    <span class={`bus-status ${stale ? 'stale' : status}`} title={sentence}>
      <StatusDot status={stale ? 'stale' : status} />
      {label}
    </span>
  )
}

/** The status of a gauge on the bus. Data exchange is a statement about now: of a gauge without current readings it is not known. */
export function GaugeStatus({ gauge, stale }: { gauge: Gauge; stale: boolean }): JSX.Element {
  if (!stale || gauge.state !== 'data-exchange') return <BusStatusMark status={gauge.state} />
  return (
    <span class="bus-status stale" title={t.unknownStatus.sentence}>
      {t.unknownStatus.label}
    </span>
  )
}

/** The symbol of a status: each has another shape, and none is that of an alarm. */
export function StatusDot({ status }: { status: BusStatus | 'stale' }): JSX.Element {
  return <span class={`dot ${status}`} aria-hidden="true" />
}
