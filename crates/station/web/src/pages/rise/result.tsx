// The result of a rate-of-rise fit: its meaning, its parts, and flows if the volume is known.

import './result.css'
import type { ComponentChildren, JSX } from 'preact'
import type { Rise } from '../../api/types.ts'
import { Pressure } from '../../components/pressure.tsx'
import { age, number } from '../../lib/format.ts'
import { verdict } from '../../lib/rise.ts'
import { FLOWS } from '../../lib/units.ts'
import { useUnit } from '../../settings.ts'

interface Props {
  fit: Rise | null
  error: string | null
  volume: number | null
}

export function Result({ fit, error, volume }: Props): JSX.Element {
  const unit = useUnit()
  if (error) return <p class="error">{error}</p>
  if (!fit) return <p class="panel muted">The result appears here when start and end are set.</p>
  const { title, sentence } = verdict(fit)
  return (
    <section class="panel result" aria-label="Result" role="status">
      <h2>{title}</h2>
      <p>{sentence}</p>
      <dl class="facts">
        <Fact name="steady rise">
          <Pressure pa={fit.steady_pa_per_s} unit={unit} />
          /s
        </Fact>
        {fit.bend_pa !== null && fit.tau_s !== null && (
          <Fact name="outgassing part">
            <Pressure pa={fit.bend_pa} unit={unit} />, 63 % after {age(fit.tau_s * 1000)}
          </Fact>
        )}
        <Fact name="variance explained">{(fit.explained * 100).toFixed(1)} %</Fact>
        <Fact name="samples">{fit.samples}</Fact>
      </dl>
      {volume === null ? <p class="muted">Enter the volume to see flows.</p> : <Flows fit={fit} />}
    </section>
  )
}

function Fact({ name, children }: { name: string; children: ComponentChildren }): JSX.Element {
  return (
    <div>
      <dt>{name}</dt>
      <dd>{children}</dd>
    </div>
  )
}

function Flows({ fit }: { fit: Rise }): JSX.Element {
  const rows: [string, number | null][] = [
    ['leak', fit.leak_pa_m3_per_s],
    ['outgassing, at the start', fit.outgassing_pa_m3_per_s],
  ]
  return (
    <table class="flows">
      <caption class="visually-hidden">Flows of leak and outgassing</caption>
      <thead>
        <tr>
          <th scope="col">Flow</th>
          {FLOWS.map(({ name }) => (
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
            {FLOWS.map(({ name, factor }) => (
              <td key={name}>{flow === null ? 'not separable' : number(flow * factor)}</td>
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  )
}
