// The steps of a measurement: gauge, start, end, volume.

import './steps.css'
import type { JSX } from 'preact'
import { Choice, MomentField, sameText } from '../../components/fields.tsx'
import { moment, momentOf } from '../../lib/format.ts'
import { useLive } from '../../live.ts'
import { GAS_DEPENDENCES, type GasDependence, type Measurement } from './measurement.ts'

interface Props {
  /** All series. */
  names: string[]
  measurement: Measurement
  change: (measurement: Measurement) => void
}

export function Steps({ names, measurement, change }: Props): JSX.Element {
  const { series, begin, end, litres, gauge, accuracy } = measurement
  return (
    <ol class="steps panel">
      <li>
        <span class="step">Choose the gauge</span>
        <Choice
          label="Choose the gauge"
          value={series}
          options={sameText(names)}
          onChange={(series) => change({ ...measurement, series, begin: null, end: null })}
        />
      </li>
      <li>
        <TimeStep
          text="Close the valve to the pump and set the start"
          button="Start now"
          at={begin}
          set={(begin) => change({ ...measurement, begin, end: null })}
        />
      </li>
      <li>
        <TimeStep
          text="Wait, then set the end"
          button="End now"
          at={end}
          set={(end) => change({ ...measurement, end })}
        />
      </li>
      <li>
        <label>
          <span class="step">Enter the volume to see flows</span>
          <input
            class="short"
            type="number"
            min="0"
            step="any"
            inputMode="decimal"
            value={litres}
            onInput={(event) => change({ ...measurement, litres: event.currentTarget.value })}
          />{' '}
          L
        </label>
      </li>
      <li>
        <span class="step">Choose how the gauge depends on the gas</span>
        <Choice
          label="Choose how the gauge depends on the gas"
          value={gauge}
          options={GAS_DEPENDENCES}
          onChange={(gauge) => change({ ...measurement, gauge: gauge as GasDependence })}
        />
      </li>
      <li>
        <label>
          <span class="step">Enter the accuracy of the gauge from its manual</span>±
          <input
            class="short"
            type="number"
            min="0"
            max="100"
            step="any"
            inputMode="decimal"
            value={accuracy}
            onInput={(event) => change({ ...measurement, accuracy: event.currentTarget.value })}
          />{' '}
          %
        </label>
      </li>
    </ol>
  )
}

interface TimeStepProps {
  text: string
  button: string
  at: number | null
  set: (at: number) => void
}

function TimeStep({ text, button, at, set }: TimeStepProps): JSX.Element {
  const { now } = useLive()
  const changed = (typed: string): void => {
    const time = momentOf(typed)
    if (time !== null) set(time)
  }
  return (
    <div class="time-step">
      <span>{text}</span>
      <button type="button" class="main" onClick={() => set(now)}>
        {button}
      </button>
      <MomentField label={text} value={at === null ? '' : moment(at)} onChange={changed} />
    </div>
  )
}
