// Figures of the alarms after ISA-18.2: how many, how often, which.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { fetchAlarmPerformance } from '../../api/calls.ts'
import type { AlarmPerformance } from '../../api/types.ts'
import { ClosedPart } from '../../components/closed-part.tsx'
import { Choice } from '../../components/fields.tsx'
import { useQuery } from '../../components/hooks.ts'
import { QueryState } from '../../components/query-state.tsx'
import { Unbroken } from '../../components/unbroken.tsx'
import { moment } from '../../lib/format.ts'
import { type Share, sharesOf } from '../../lib/performance.ts'
import { live } from '../../live.ts'
import { t } from '../../texts/texts.ts'

const REFRESH_MS = 60_000
const DAY_MS = 86_400_000
const periods = (): [string, string][] => [
  ['1', t.performance.lastDay],
  ['7', t.performance.lastWeek],
  ['30', t.performance.last30Days],
]

export function Performance(): JSX.Element {
  return (
    <section class="panel alarm-performance" aria-label={t.performance.label}>
      <ClosedPart title={t.performance.title} draw={() => <Panel />} />
    </section>
  )
}

function Panel(): JSX.Element {
  const [days, setDays] = useState('1')
  const query = useQuery(`performance ${days}`, REFRESH_MS, (signal) => {
    const to = Math.ceil(live().now)
    return fetchAlarmPerformance(to - Number(days) * DAY_MS, to, signal)
  })
  return (
    <>
      <div class="bar">
        <Choice label={t.performance.period} value={days} options={periods()} onChange={setDays} />
        <span class="muted">{t.performance.targets}</span>
      </div>
      <QueryState of={[query]} />
      {query.value && <Figures figures={query.value} />}
    </>
  )
}

interface Row {
  figure: string
  value: string
  target: string
  /** Whether the figure is beyond its target. */
  isBeyond?: boolean
}

/** A shorter time has no rate: a few alarms of its first minute would be hundreds an hour. */
const LEAST_HOURS = 1

/** The figures with their targets: ANSI/ISA-18.2-2016, clause 16, table of recommended metrics. */
function rows(figures: AlarmPerformance): Row[] {
  const { raised, worst_ten_minutes: worst, flood_percent, chattering, long_active } = figures
  const per_hour = figures.recorded_hours < LEAST_HOURS ? null : figures.per_hour
  return [
    { figure: t.performance.alarms, value: `${raised}`, target: '' },
    { figure: t.performance.suppressed, value: `${figures.suppressed}`, target: '' },
    {
      figure: t.performance.perHour,
      value: per_hour == null ? '–' : per_hour.toFixed(1),
      target: t.performance.perHourTarget,
      isBeyond: per_hour != null && per_hour > 12,
    },
    {
      figure: t.performance.worst,
      value: worst ? t.performance.worstAt(worst.raised, moment(worst.from_ms)) : '0',
      target: t.performance.worstTarget,
      isBeyond: worst != null && worst.raised > 10,
    },
    {
      figure: t.performance.flood,
      value: flood_percent == null ? '–' : `${flood_percent.toFixed(1)} %`,
      target: t.performance.floodTarget,
      isBeyond: flood_percent != null && flood_percent >= 1,
    },
    ...sharesOf(figures).map(shareRow),
    {
      figure: t.performance.chattering,
      value: listed(chattering),
      target: t.common.none,
      isBeyond: chattering.length > 0,
    },
    {
      figure: t.performance.longActive,
      value: listed(long_active),
      target: t.performance.longActiveTarget,
      isBeyond: long_active.length >= 5,
    },
  ]
}

const shareRow = ({ priority, percent, recommended, isBeyond }: Share): Row => ({
  figure: t.performance.share(t.priorities[priority]),
  value: percent === null ? '–' : `${Math.round(percent)} %`,
  target: t.performance.shareTarget(recommended),
  isBeyond,
})

const listed = (names: string[]): string =>
  names.length === 0 ? t.common.none : `${names.length}: ${names.join(', ')}`

/** A figure beyond its target: colour is for alarms, so it has a shape, words and weight. */
function Beyond({ value }: { value: string }): JSX.Element {
  return (
    <>
      <strong>
        <span aria-hidden="true">▲</span> <Unbroken text={value} />
      </strong>{' '}
      {t.performance.beyond}
    </>
  )
}

function Figures({ figures }: { figures: AlarmPerformance }): JSX.Element {
  const { most_frequent, recorded_hours } = figures
  return (
    <>
      <p class="muted">{t.performance.recorded(recorded_hours.toFixed(1))}</p>
      <table class="stacked">
        <caption class="visually-hidden">{t.performance.label}</caption>
        <thead>
          <tr>
            <th scope="col">{t.performance.figure}</th>
            <th scope="col">{t.common.value}</th>
            <th scope="col">{t.performance.target}</th>
          </tr>
        </thead>
        <tbody>
          {rows(figures).map(({ figure, value, target, isBeyond }) => (
            <tr key={figure} data-beyond={isBeyond ? '' : undefined}>
              <th scope="row">{figure}</th>
              <td>{isBeyond ? <Beyond value={value} /> : <Unbroken text={value} />}</td>
              <td class="muted" data-title={target && t.performance.target}>
                <Unbroken text={target} />
              </td>
            </tr>
          ))}
        </tbody>
      </table>
      {most_frequent.length > 0 && (
        <table>
          <caption>{t.performance.frequent}</caption>
          <thead>
            <tr>
              <th scope="col">{t.common.alarm}</th>
              <th scope="col">{t.performance.raised}</th>
              <th scope="col">{t.performance.part}</th>
            </tr>
          </thead>
          <tbody>
            {most_frequent.map(({ alarm, raised, percent }) => (
              <tr key={alarm}>
                <th scope="row">
                  <Unbroken text={alarm} />
                </th>
                <td>{raised}</td>
                <td>{percent.toFixed(0)} %</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
    </>
  )
}
