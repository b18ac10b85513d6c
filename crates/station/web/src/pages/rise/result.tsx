// The result of a rate-of-rise fit: its meaning, its parts, and flows if the volume is known.

import './result.css'
import type { ComponentChildren, JSX } from 'preact'
import type { FlowUnits, Interval, Rise } from '../../api/types.ts'
import { Pressure } from '../../components/pressure.tsx'
import { age, number } from '../../lib/format.ts'
import { verdict } from '../../lib/rise.ts'
import { useUnit } from '../../settings.ts'
import type { GasDependence } from './measurement.ts'

interface Props {
  fit: Rise | null
  gauge: GasDependence
  error: string | null
}

export function Result({ fit, gauge, error }: Props): JSX.Element {
  if (error) return <p class="error">{error}</p>
  if (!fit) return <p class="panel muted">The result appears here when start and end are set.</p>
  const { title, sentence } = verdict(fit)
  return (
    <section class="panel result" aria-label="Result" role="status">
      <h2>{title}</h2>
      <p>{sentence}</p>
      <dl class="facts">
        <Fact name="leak">
          <Rate rate={fit.leak_pa_per_s} />
        </Fact>
        <Fact name="outgassing, at the start">
          <Rate rate={fit.outgassing_pa_per_s} />
        </Fact>
        {fit.tau_s !== null && <Fact name="time constant of saturation">{age(fit.tau_s * 1000)}</Fact>}
        <Fact name="pumped before">{fit.pumped_s === null ? 'not recorded' : age(fit.pumped_s * 1000)}</Fact>
        <Fact name="samples">{fit.samples}</Fact>
      </dl>
      <p class="muted">
        Intervals contain the true value with a probability of 95 %,{' '}
        {fit.accuracy === null
          ? 'without the uncertainty of the gauge'
          : `with an accuracy of the gauge of ±${percent(fit.accuracy)} %`}
        .{' '}
        {gauge === 'none'
          ? 'The rates are as indicated, not corrected for the gas'
          : 'The rates are corrected for the gas: a leak of air, outgassing of water'}
        ; sccm are for gas at 20 °C.
      </p>
      {fit.flows ? <Flows flows={fit.flows} /> : <p class="muted">Enter the volume to see flows.</p>}
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
  const unit = useUnit()
  return (
    <>
      <Pressure pa={rate.mean} unit={unit} />
      /s (<Pressure pa={rate.low} unit={unit} /> to <Pressure pa={rate.high} unit={unit} />)
    </>
  )
}

const UNITS: [string, keyof FlowUnits][] = [
  ['mbar L/s', 'mbar_l_per_s'],
  ['Pa m³/s', 'pa_m3_per_s'],
  ['sccm', 'sccm'],
]

function Flows({ flows }: { flows: NonNullable<Rise['flows']> }): JSX.Element {
  const rows: [string, FlowUnits][] = [
    ['leak', flows.leak],
    ['outgassing, at the start', flows.outgassing],
  ]
  return (
    <table class="flows">
      <caption class="visually-hidden">Flows of leak and outgassing</caption>
      <thead>
        <tr>
          <th scope="col">Flow</th>
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
                <small>
                  {number(flow[key].low)} to {number(flow[key].high)}
                </small>
              </td>
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  )
}
