// What to identify: gauge, pump-down, volume, and what else is known.

import type { JSX } from 'preact'
import type { PumpDown } from '../../api/types.ts'
import { Choice, MomentField, sameText } from '../../components/fields.tsx'
import { moment } from '../../lib/format.ts'
import { useUnit } from '../../settings.ts'
import { GAS_DEPENDENCES, type GasDependence } from '../rise/measurement.ts'
import type { PlantChoice } from './request.ts'

interface Props {
  names: string[]
  choice: PlantChoice
  runs: PumpDown[]
  /** The chosen pump-down. */
  run: PumpDown | null
  /** What is missing. */
  problem: string | null
  change: (choice: PlantChoice) => void
  submit: () => void
}

export function Form({ names, choice, runs, run, problem, change, submit }: Props): JSX.Element {
  const unit = useUnit()
  const set = (name: keyof PlantChoice) => (value: string) => change({ ...choice, [name]: value })
  const starts = runs.map(({ start_ms }): [string, string] => [String(start_ms), moment(start_ms)])
  return (
    <form
      class="panel"
      onSubmit={(event) => {
        event.preventDefault()
        if (problem === null) submit()
      }}
    >
      <div class="known">
        <div class="field">
          <span>Gauge</span>
          <Choice
            label="Gauge"
            value={choice.series}
            options={sameText(names)}
            onChange={(series) => change({ ...choice, series, run: '', from: '', to: '', closed: '', opened: '' })}
          />
        </div>
        <div class="field">
          <span>Pump-down</span>
          <Choice
            label="Pump-down"
            value={run ? String(run.start_ms) : ''}
            options={starts.length > 0 ? starts : [['', 'none in the last 90 days']]}
            onChange={set('run')}
          />
        </div>
        <Amount label="Volume" unit="L" value={choice.litres} change={set('litres')} />
        <Amount
          label="Accuracy of the gauge from its manual, ±"
          unit="%"
          value={choice.accuracy}
          change={set('accuracy')}
        />
        <Amount label="Target pressure" unit={unit} value={choice.target} change={set('target')} />
        <div class="field">
          <span>Gas correction</span>
          <Choice
            label="Gas correction"
            value={choice.gauge}
            options={GAS_DEPENDENCES}
            onChange={(gauge) => change({ ...choice, gauge: gauge as GasDependence })}
          />
        </div>
      </div>
      <details open={[choice.from, choice.to, choice.closed, choice.opened, choice.dose, choice.doseAt].some(Boolean)}>
        <summary>Times of the record, volume from a dose</summary>
        <div class="known">
          <Time label="Start of the pump-down" value={choice.from} change={set('from')} />
          <Time label="End of the record" value={choice.to} change={set('to')} />
          <Time label="Valve closed (found if empty)" value={choice.closed} change={set('closed')} />
          <Time label="Valve opened (found if empty)" value={choice.opened} change={set('opened')} />
          <Amount label="Dose in place of the volume" unit="mbar L" value={choice.dose} change={set('dose')} />
          <Time label="Dose let in" value={choice.doseAt} change={set('doseAt')} />
        </div>
      </details>
      <p>
        <button type="submit" class="main" disabled={problem !== null}>
          Identify
        </button>{' '}
        <span class="muted">{problem}</span>
      </p>
    </form>
  )
}

interface FieldProps {
  label: string
  value: string
  change: (text: string) => void
}

function Amount({ label, unit, value, change }: FieldProps & { unit: string }): JSX.Element {
  return (
    <label>
      <span>{label}</span>
      <input
        class="short"
        type="number"
        min="0"
        step="any"
        inputMode="decimal"
        value={value}
        onInput={(event) => change(event.currentTarget.value)}
      />{' '}
      {unit}
    </label>
  )
}

function Time({ label, value, change }: FieldProps): JSX.Element {
  return (
    <div class="field">
      <span>{label}</span>
      <MomentField label={label} value={value} onChange={change} />
    </div>
  )
}
