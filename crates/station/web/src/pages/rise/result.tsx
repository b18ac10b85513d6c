// The result of a rate-of-rise fit: its meaning, its parts, and flows if the volume is known.

import './result.css'
import type { ComponentChildren, JSX } from 'preact'
import type { FlowUnits, Interval, Rise } from '../../api/types.ts'
import type { Query } from '../../components/hooks.ts'
import { Pressure } from '../../components/pressure.tsx'
import { QueryState } from '../../components/query-state.tsx'
import { age, number } from '../../lib/format.ts'
import { verdict } from '../../lib/rise.ts'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'
import type { GasDependence } from './measurement.ts'

interface Props {
  fit: Rise | null
  /** Start and end are set. */
  isReady: boolean
  gauge: GasDependence
  query: Pick<Query<Rise | null>, 'value' | 'error' | 'again'>
}

export function Result({ fit, isReady, gauge, query }: Props): JSX.Element {
  if (!isReady) return <p class="panel muted">{t.rise.waiting}</p>
  // A fit beside a failure would be that of other times.
  if (!fit || query.error) return <QueryState of={[{ ...query, value: fit }]} loading={t.rise.calculating} />
  const { title, sentence } = verdict(fit)
  return (
    <section class="panel result" aria-label={t.rise.result} role="status">
      <h2>{title}</h2>
      <p>{sentence}</p>
      <dl class="facts">
        <Fact name={t.rise.leak}>
          <Rate rate={fit.leak_pa_per_s} />
        </Fact>
        <Fact name={t.rise.outgassing}>
          <Rate rate={fit.outgassing_pa_per_s} />
        </Fact>
        {fit.tau_s !== null && <Fact name={t.rise.tau}>{age(fit.tau_s * 1000)}</Fact>}
        <Fact name={t.rise.pumped}>{fit.pumped_s === null ? t.rise.notRecorded : age(fit.pumped_s * 1000)}</Fact>
        <Fact name={t.rise.samples}>{fit.samples}</Fact>
      </dl>
      <p class="muted">
        {t.rise.intervals(
          fit.accuracy === null ? t.common.withoutAccuracy : t.common.withAccuracy(`${percent(fit.accuracy)}`),
        )}{' '}
        {gauge === 'none' ? t.rise.asIndicated : t.rise.corrected}
      </p>
      {fit.flows ? <Flows flows={fit.flows} /> : <p class="muted">{t.rise.enterVolume}</p>}
    </section>
  )
}

/** A fraction in per cent, with the digits that the user typed. */
const percent = (fraction: number): number => Number((fraction * 100).toPrecision(6))

function Fact({ name, children }: { name: string; children: ComponentChildren }): JSX.Element {
  return (
    <div>
      <dt>{name}</dt>
      <dd>{children}</dd>
    </div>
  )
}

function Rate({ rate }: { rate: Interval }): JSX.Element {
  return (
    <>
      <PerSecond pa={rate.mean} /> ({t.common.range(<PerSecond pa={rate.low} />, <PerSecond pa={rate.high} />)})
    </>
  )
}

function PerSecond({ pa }: { pa: number }): JSX.Element {
  const unit = useUnit()
  return (
    <span class="rate">
      <Pressure pa={pa} unit={unit} />
      /s
    </span>
  )
}

const UNITS: [string, keyof FlowUnits][] = [
  ['mbar L/s', 'mbar_l_per_s'],
  ['Pa m³/s', 'pa_m3_per_s'],
  ['sccm', 'sccm'],
]

function Flows({ flows }: { flows: NonNullable<Rise['flows']> }): JSX.Element {
  const rows: [string, FlowUnits][] = [
    [t.rise.leak, flows.leak],
    [t.rise.outgassing, flows.outgassing],
  ]
  return (
    <table class="flows">
      <caption class="visually-hidden">{t.rise.flows}</caption>
      <thead>
        <tr>
          <th scope="col">{t.rise.flow}</th>
          {UNITS.map(([name]) => (
            <th scope="col" key={name}>
              {name}
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {rows.map(([name, flow]) => (
          <tr key={name}>
            <th scope="row">{name}</th>
            {UNITS.map(([unit, key]) => (
              <td key={unit}>
                {number(flow[key].mean)}
                <small>{t.common.rangeText(number(flow[key].low), number(flow[key].high))}</small>
              </td>
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  )
}
