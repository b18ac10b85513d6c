// Figures of the alarms after ISA-18.2: how many, how often, which.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { fetchAlarmPerformance } from '../../api/calls.ts'
import type { AlarmPerformance } from '../../api/types.ts'
import { Choice } from '../../components/fields.tsx'
import { useQuery } from '../../components/hooks.ts'
import { moment } from '../../lib/format.ts'
import { live } from '../../live.ts'

const REFRESH_MS = 60_000
const DAY_MS = 86_400_000
const PERIODS: [string, string][] = [
  ['1', 'last day'],
  ['7', 'last week'],
  ['30', 'last 30 days'],
]

export function Performance(): JSX.Element {
  const [days, setDays] = useState('1')
  const query = useQuery(`performance ${days}`, REFRESH_MS, (signal) => {
    const to = Math.ceil(live().now)
    return fetchAlarmPerformance(to - Number(days) * DAY_MS, to, signal)
  })
  return (
    <section class="panel alarm-performance" aria-label="Alarm performance">
      <details>
        <summary>
          <h2>Performance</h2>
        </summary>
        <div class="bar">
          <Choice label="Period" value={days} options={PERIODS} onChange={setDays} />
          <span class="muted">Targets: ISA-18.2, for one operator.</span>
        </div>
        {query.error && <p class="error">{query.error}</p>}
        {query.value && <Figures figures={query.value} />}
      </details>
    </section>
  )
}

interface Row {
  figure: string
  value: string
  target: string
}

/** The figures with their targets: ANSI/ISA-18.2-2016, clause 16, table of recommended metrics. */
function rows(figures: AlarmPerformance): Row[] {
  const { raised, per_hour, worst_ten_minutes: worst, flood_percent, by_priority, chattering, long_active } = figures
  const part = (count: number): string => (raised === 0 ? '–' : `${Math.round((100 * count) / raised)} %`)
  const { high, medium, low } = by_priority
  return [
    { figure: 'alarms', value: `${raised}`, target: '' },
    { figure: 'suppressed by a plant state, not among them', value: `${figures.suppressed}`, target: '' },
    { figure: 'per hour', value: per_hour == null ? '–' : per_hour.toFixed(1), target: 'about 6, at most 12' },
    {
      figure: 'most in ten minutes',
      value: worst ? `${worst.raised}, from ${moment(worst.from_ms)}` : '0',
      target: 'at most 10',
    },
    {
      figure: 'time with more than ten in ten minutes',
      value: flood_percent == null ? '–' : `${flood_percent.toFixed(1)} %`,
      target: 'below 1 %',
    },
    {
      figure: 'high, medium, low',
      value: `${part(high)}, ${part(medium)}, ${part(low)}`,
      target: 'about 5, 15, 80 %',
    },
    { figure: 'chattering', value: listed(chattering), target: 'none' },
    { figure: 'active for more than a day', value: listed(long_active), target: 'fewer than 5' },
  ]
}

const listed = (names: string[]): string => (names.length === 0 ? 'none' : `${names.length}: ${names.join(', ')}`)

function Figures({ figures }: { figures: AlarmPerformance }): JSX.Element {
  const { most_frequent, recorded_hours } = figures
  return (
    <>
      <p class="muted">The station recorded {recorded_hours.toFixed(1)} hours of this time; rates refer to them.</p>
      <table>
        <caption class="visually-hidden">Alarm performance</caption>
        <thead>
          <tr>
            <th scope="col">Figure</th>
            <th scope="col">Value</th>
            <th scope="col">Target</th>
          </tr>
        </thead>
        <tbody>
          {rows(figures).map(({ figure, value, target }) => (
            <tr key={figure}>
              <th scope="row">{figure}</th>
              <td>{value}</td>
              <td class="muted">{target}</td>
            </tr>
          ))}
        </tbody>
      </table>
      {most_frequent.length > 0 && (
        <table>
          <caption>Most frequent alarms</caption>
          <thead>
            <tr>
              <th scope="col">Alarm</th>
              <th scope="col">Raised</th>
              <th scope="col">Part of all</th>
            </tr>
          </thead>
          <tbody>
            {most_frequent.map(({ alarm, raised, percent }) => (
              <tr key={alarm}>
                <th scope="row">{alarm}</th>
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
