// What to identify: gauge, pump-down, volume, and what else is known.

import type { JSX } from 'preact'
import type { PumpDown } from '../../api/types.ts'
import { Choice, MomentField, sameText } from '../../components/fields.tsx'
import { moment } from '../../lib/format.ts'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'
import { gasDependence, gasDependences } from '../rise/measurement.ts'
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
          <span>{t.common.gauge}</span>
          <Choice
            label={t.common.gauge}
            value={choice.series}
            options={sameText(names)}
            onChange={(series) => change({ ...choice, series, run: '', from: '', to: '', closed: '', opened: '' })}
          />
        </div>
        <div class="field">
          <span>{t.identify.pumpDown}</span>
          <Choice
            label={t.identify.pumpDown}
            value={run ? String(run.start_ms) : ''}
            options={starts.length > 0 ? starts : [['', t.identify.noPumpDown]]}
            onChange={set('run')}
          />
        </div>
        <Amount label={t.identify.volume} unit="L" value={choice.litres} change={set('litres')} />
        <Amount label={t.identify.accuracy} unit="%" value={choice.accuracy} change={set('accuracy')} />
        <Amount label={t.identify.target} unit={unit} value={choice.target} change={set('target')} />
        <div class="field">
          <span>{t.identify.gas}</span>
          <Choice
            label={t.identify.gas}
            value={choice.gauge}
            options={gasDependences()}
            onChange={(gauge) => change({ ...choice, gauge: gasDependence(gauge) })}
          />
        </div>
      </div>
      <details open={[choice.from, choice.to, choice.closed, choice.opened, choice.dose, choice.doseAt].some(Boolean)}>
        <summary>{t.identify.times}</summary>
        <div class="known">
          <Time label={t.identify.from} value={choice.from} change={set('from')} />
          <Time label={t.identify.to} value={choice.to} change={set('to')} />
          <Time label={t.identify.closed} value={choice.closed} change={set('closed')} />
          <Time label={t.identify.opened} value={choice.opened} change={set('opened')} />
          <Amount label={t.identify.dose} unit="mbar L" value={choice.dose} change={set('dose')} />
          <Time label={t.identify.doseAt} value={choice.doseAt} change={set('doseAt')} />
        </div>
      </details>
      <p>
        <button type="submit" class="main" disabled={problem !== null}>
          {t.identify.submit}
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
