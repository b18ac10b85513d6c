// The measured pressure and the fit. Dragging sets start and end.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import type { Rise } from '../../api/types.ts'
import { Chart, timePixels } from '../../components/chart.tsx'
import { marksHeight } from '../../components/chart-names.ts'
import type { Line, TimeMark } from '../../components/chart-overlays.ts'
import { ChartTable } from '../../components/chart-table.tsx'
import { useWidth } from '../../components/hooks.ts'
import { Pressure, SampleText } from '../../components/pressure.tsx'
import { QueryState } from '../../components/query-state.tsx'
import {
  type ChartData,
  extent,
  hasNoValues,
  rangeAfterKey,
  seriesAt,
  useChartData,
  useTrends,
} from '../../components/use-trends.ts'
import { curveColour } from '../../lib/curves.ts'
import { isLive, type Range, windowOf, zoomed } from '../../lib/range.ts'
import { fitted, scaleFrom } from '../../lib/rise.ts'
import type { Curve } from '../../lib/series.ts'
import { inUnit, type Unit } from '../../lib/units.ts'
import { useLive } from '../../live.ts'
import { useDark, useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'
import { HOME, type Measurement, windowAround } from './measurement.ts'

/** The height of the chart, in CSS pixels. */
const HEIGHT = 300

interface Props {
  measurement: Measurement
  fit: Rise | null
  select: (begin: number, end: number) => void
}

export function RiseChart({ measurement, fit, select }: Props): JSX.Element {
  const live = useLive()
  const unit = useUnit()
  const dark = useDark()
  const [box, width] = useWidth()
  const [zoom, setZoom] = useState<Range | null>(null)
  const range = zoom ?? windowAround(measurement, live.now)
  const query = useTrends([measurement.series], range, timePixels(width, false))
  const data = useChartData(query.value, range, unit, live.now)
  const window = windowOf(range, live.now)
  const fitAt = fitFunction(measurement, fit, live.now)
  const { curves, lines } = withFit(data, fitAt, unit, dark)
  const marks = marksOf(measurement)
  const shown: [number, number] = [
    scaleFrom(data.times, data.curves[0]?.mean ?? [], window, measurement.begin),
    window[1],
  ]
  return (
    <div class="panel" ref={box}>
      <p class="muted hint">
        {t.rise.drag}
        {fit && (
          <span class="fit" style={{ color: curveColour(1, dark) }}>
            ╌╌ {t.rise.fit}
          </span>
        )}
      </p>
      {query.value === null ? (
        <div class="chart-place" style={{ height: `${HEIGHT}px` }}>
          <QueryState of={[query]} />
        </div>
      ) : (
        <Chart
          label={t.rise.chart(measurement.series, unit)}
          times={data.times}
          curves={curves}
          lines={lines}
          window={window}
          scale={linearScale(extent(data, shown), marksHeight(marks.length) / HEIGHT)}
          log={false}
          unit={unit}
          marks={marks}
          width={width}
          height={HEIGHT}
          dark={dark}
          onSelect={select}
          onZoom={(at, factor) => setZoom(zoomed(window, at, factor))}
          onKey={(key) => {
            const next = rangeAfterKey(key, range, live.now, HOME)
            if (next) setZoom(isLive(next) ? null : next)
            return next !== null
          }}
        />
      )}
      <ChartTable
        caption={t.rise.pressureOf(measurement.series)}
        window={window}
        columns={[
          {
            name: measurement.series,
            cell: (at) => <SampleText sample={seriesAt(data, measurement.series, at)} unit={unit} />,
          },
          { name: t.rise.fit, cell: (at) => <FitText pa={fitAt(at)} unit={unit} /> },
        ]}
      />
      {query.value !== null && <QueryState of={[query]} empty={hasNoValues(data) && t.log.noValues} />}
    </div>
  )
}

/** The fitted pressure in Pa at a time; `null` outside the measurement. */
function fitFunction({ begin, end }: Measurement, fit: Rise | null, now: number): (at: number) => number | null {
  if (fit === null || begin === null) return () => null
  return (at) => (at < begin || at > (end ?? now) ? null : fitted(fit, (at - begin) / 1000))
}

function FitText({ pa, unit }: { pa: number | null; unit: Unit }): JSX.Element | null {
  return pa === null ? null : <Pressure pa={pa} unit={unit} />
}

/** The measured curve, and the fit if there is one. */
function withFit(
  data: ChartData,
  fitAt: (at: number) => number | null,
  unit: Unit,
  dark: boolean,
): { curves: Curve[]; lines: Line[] } {
  const measured: Line[] = data.trends.map(({ series }, index) => ({
    name: series,
    colour: curveColour(0, dark),
    stretches: data.stretches[index] ?? [],
  }))
  const means = data.times.map(fitAt)
  if (measured.length === 0 || means.every((pa) => pa === null)) return { curves: data.curves, lines: measured }
  const none = means.map(() => null)
  const fit: Curve = { low: none, high: none, mean: means.map((pa) => pa && inUnit(pa, unit)) }
  return {
    curves: [...data.curves, fit],
    lines: [...measured, { name: t.rise.fit, colour: curveColour(1, dark), dashed: true, stretches: [] }],
  }
}

function marksOf({ begin, end }: Measurement): TimeMark[] {
  return [
    ...(begin === null ? [] : [{ at: begin, name: t.rise.valveClosed }]),
    ...(end === null ? [] : [{ at: end, name: t.rise.end }]),
  ]
}

/** A linear scale with a margin; `names` is the part of the height that the names of the marks take at the top. */
function linearScale([low, high]: [number, number], names: number): [number, number] {
  if (!Number.isFinite(low)) return [0, 1]
  const span = high - low || high
  return [Math.max(0, low - span * 0.08), high + span * (0.08 + names * 1.5)]
}
