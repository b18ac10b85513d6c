// The series below a chart: which are drawn, and their values at the cursor or now. The list is never empty, so the page does
// not jump when the cursor comes and goes.

import './series-list.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import type { Gauge, Quality, StationEvent } from '../api/types.ts'
import { type Difference, differenceParts } from '../lib/difference.ts'
import { moment } from '../lib/format.ts'
import { matchesWords } from '../lib/search.ts'
import { qualityOf, type Sample } from '../lib/series.ts'
import { currentQuality } from '../lib/stale.ts'
import type { Unit } from '../lib/units.ts'
import { useLive } from '../live.ts'
import { t } from '../texts/texts.ts'
import { SearchField } from './fields.tsx'
import { boundOf, ReadingText } from './pressure.tsx'

export interface SeriesListProps {
  all: { series: string; gauge: Gauge }[]
  chosen: string[]
  colourOf: (series: string) => string
  toggle: (series: string) => void
  unit: Unit
  /** The time at the cursor; `null` without a cursor. */
  at: number | null
  sampleOf: (series: string, at: number) => Sample | null
  /** The events at the cursor. */
  events: StationEvent[]
  /** What the shown value of a series is beside the reference; `null` without both values. */
  differenceOf: (series: string) => Difference | null
}

/** Above this number of series the list has a search, and shows as many series beside those that are drawn. */
const MOST_LISTED = 24

export function SeriesList(props: SeriesListProps): JSX.Element {
  const { at, all, chosen, events } = props
  const [text, setText] = useState('')
  const isLong = all.length > MOST_LISTED
  const isDrawn = ({ series }: { series: string }): boolean => chosen.includes(series)
  const found = all.filter(
    (one) => !isDrawn(one) && matchesWords([one.series, one.gauge.segment, one.gauge.device], text),
  )
  const listed = isLong ? [...all.filter(isDrawn), ...found.slice(0, MOST_LISTED)] : all
  const hidden = isLong ? found.length - MOST_LISTED : 0
  return (
    <div class="series-list panel">
      <p class="cursor-time">
        <strong>{at === null ? t.common.now : moment(at)}</strong>
        <span class="muted">{events.map(({ text }) => text).join('; ')}</span>
      </p>
      {isLong && <SearchField label={t.trends.search} value={text} onInput={setText} />}
      <ul>
        {listed.map(({ series, gauge }) => (
          <Item series={series} gauge={gauge} {...props} key={series} />
        ))}
      </ul>
      {hidden > 0 && <p class="muted">{t.trends.moreSeries(hidden)}</p>}
    </div>
  )
}

function Item(props: SeriesListProps & { series: string; gauge: Gauge }): JSX.Element {
  const { series, chosen, colourOf, toggle, unit, at, differenceOf } = props
  const drawn = chosen.includes(series)
  const [pa, quality] = useValue(props, drawn)
  const colour = colourOf(series)
  const difference = drawn ? differenceOf(series) : null
  return (
    <li class={drawn ? '' : 'off'}>
      <label>
        <input type="checkbox" checked={drawn} onChange={() => toggle(series)} style={{ accentColor: colour }} />
        <span class="swatch" style={drawn ? { background: colour, borderColor: colour } : {}} aria-hidden="true" />
        <span class="name">{series}</span>
        <span class="value">{(at === null || drawn) && <ReadingText pa={pa} quality={quality} unit={unit} />}</span>
      </label>
      {difference && <DifferenceParts difference={difference} unit={unit} />}
    </li>
  )
}

function DifferenceParts({ difference, unit }: { difference: Difference; unit: Unit }): JSX.Element {
  return (
    <dl class="difference">
      {differenceParts(difference, unit).map(({ heading, value, unit }) => (
        <div key={heading + unit}>
          <dt>{heading}</dt>
          <dd>
            {value} {unit && <span class="unit">{unit}</span>}
          </dd>
        </div>
      ))}
    </dl>
  )
}

/** The value at the cursor if the series is drawn, the present value otherwise. */
function useValue(props: SeriesListProps & { series: string; gauge: Gauge }, drawn: boolean): [number | null, Quality] {
  const { series, gauge, at, sampleOf } = props
  const { since } = useLive()
  if (at !== null && drawn) {
    const sample = sampleOf(series, at)
    return sample ? [sample.mean, qualityOf(sample)] : [null, 'stale']
  }
  const reading = gauge.readings.find((reading) => reading.series === series)
  return reading ? [boundOf(reading), currentQuality(gauge, reading, since)] : [null, 'stale']
}
