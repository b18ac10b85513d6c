// Below a chart: every series, whether it is drawn, and what it shows at the cursor or now. It is never empty, so that
// nothing jumps when the cursor comes and goes.

import type { JSX } from 'preact'
import type { Gauge, Happening, Quality } from '../api.ts'
import { useLive } from '../live.ts'
import { moment } from '../pure/format.ts'
import { INVALID, OVER, UNDER } from '../pure/series.ts'
import { worth } from '../pure/stale.ts'
import type { Unit } from '../pure/units.ts'
import { Shown } from './pressure.tsx'

export interface ReadoutProps {
  all: { series: string; gauge: Gauge }[]
  chosen: string[]
  paint: (series: string) => string
  toggle: (series: string) => void
  unit: Unit
  /** Where the cursor is. */
  at: number | null
  read: (series: string) => { mean: number | null; bits: number } | null
  happenings: Happening[]
}

export function Readout(props: ReadoutProps): JSX.Element {
  const { at, all, happenings } = props
  return (
    <div class="readout panel">
      <p class="readout-time">
        <strong>{at === null ? 'now' : moment(at)}</strong>
        <span class="muted">{happenings.map(({ text }) => text).join('; ')}</span>
      </p>
      <ul>
        {all.map(({ series, gauge }) => (
          <Line series={series} gauge={gauge} {...props} key={series} />
        ))}
      </ul>
    </div>
  )
}

function Line({
  series,
  gauge,
  chosen,
  paint,
  toggle,
  unit,
  at,
  read,
}: ReadoutProps & { series: string; gauge: Gauge }): JSX.Element {
  const live = useLive()
  const drawn = chosen.includes(series)
  const reading = gauge.readings.find((reading) => reading.series === series)!
  const then = at !== null && drawn ? read(series) : null
  const [pa, quality] =
    at !== null && drawn
      ? [then?.mean ?? null, then ? qualityOf(then.bits, then.mean) : 'gap']
      : [reading.pa, worth(gauge, reading, live.since)]
  return (
    <li class={drawn ? '' : 'off'}>
      <label>
        <input type="checkbox" checked={drawn} onChange={() => toggle(series)} style={{ accentColor: paint(series) }} />
        <span
          class="swatch"
          style={drawn ? { background: paint(series), borderColor: paint(series) } : {}}
          aria-hidden="true"
        />
        <span class="name">{series}</span>
        <span class="value">
          {(at === null || drawn) && <Shown pa={pa} quality={quality as Quality} unit={unit} />}
        </span>
      </label>
    </li>
  )
}

/** The word for what occurred in a pixel: the worst that holds for its value. */
function qualityOf(bits: number, mean: number | null): Quality {
  if (bits & OVER) return 'overrange'
  if (bits & UNDER) return 'underrange'
  if (mean !== null) return 'valid'
  return bits & INVALID ? 'invalid' : 'gap'
}
