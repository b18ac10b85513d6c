// The steps of a measurement: gauge, start, end, volume.

import './steps.css'
import type { JSX } from 'preact'
import { Choice, MomentField, sameText } from '../../components/fields.tsx'
import { moment, momentOf } from '../../lib/format.ts'
import { useLive } from '../../live.ts'
import { t } from '../../texts/texts.ts'
import { gasDependence, gasDependences, type Measurement } from './measurement.ts'

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
        <span class="step">{t.rise.chooseGauge}</span>
        <Choice
          label={t.rise.chooseGauge}
          value={series}
          options={sameText(names)}
          onChange={(series) => change({ ...measurement, series, begin: null, end: null })}
        />
      </li>
      <li>
        <TimeStep
          text={t.rise.setStart}
          button={t.rise.startNow}
          at={begin}
          set={(begin) => change({ ...measurement, begin, end: null })}
        />
      </li>
      <li>
        <TimeStep text={t.rise.setEnd} button={t.rise.endNow} at={end} set={(end) => change({ ...measurement, end })} />
      </li>
      <li>
        <label>
          <span class="step">{t.rise.volume}</span>
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
        <span class="step">{t.rise.chooseGas}</span>
        <Choice
          label={t.rise.chooseGas}
          value={gauge}
          options={gasDependences()}
          onChange={(gauge) => change({ ...measurement, gauge: gasDependence(gauge) })}
        />
      </li>
      <li>
        <label>
          <span class="step">{t.rise.accuracy}</span>±
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
