// The last ten minutes of a series, or all of a recording that has just begun, as a small line. Gaps are gaps; outside its range a gauge
// has a line at the end of the range, with the band of the trends.

import './sparkline.css'
import type { JSX } from 'preact'
import { fetchTrend } from '../api/calls.ts'
import type { Trend } from '../api/types.ts'
import { age, decade, number } from '../lib/format.ts'
import { aligned, fittingSpan } from '../lib/range.ts'
import { decades, join, type Stretch, stretches, valuesOf, withRecent } from '../lib/series.ts'
import { inUnit, type Unit } from '../lib/units.ts'
import { live, recentSamples } from '../live.ts'
import { useUnit } from '../settings.ts'
import { t } from '../texts/texts.ts'
import { useQuery } from './hooks.ts'
import { QueryState } from './query-state.tsx'

const WIDTH = 240
const HEIGHT = 44
const LONGEST_MS = 600_000
const REFRESH_MS = 60_000

/** The first sample of any series of the last ten minutes: all lines have one axis, so that they can be compared. */
let earliest: number | null = null

/** The time of a pixel. */
const BIN_MS = LONGEST_MS / WIDTH

export function Sparkline({ series }: { series: string }): JSX.Element {
  const unit = useUnit()
  const query = useQuery(series, REFRESH_MS, (signal) => {
    const now = Math.round(live().now)
    const { from, to, count } = aligned([now - LONGEST_MS, now], WIDTH)
    return fetchTrend(series, from, to, count, signal)
  })
  const trend = query.value && withRecent(query.value, recentSamples(series))
  const scale = trend && scaleOf(trend, unit)
  const first = trend?.start_ms[0]
  if (first !== undefined) earliest = Math.min(first, earliest ?? first)
  // Ten minutes, or less for a recording that has just begun.
  const span = fittingSpan(earliest, live().now, LONGEST_MS)
  if (trend === null) {
    return (
      <div class="sparkline">
        <QueryState of={[query]} />
      </div>
    )
  }
  return (
    <div class="sparkline">
      <svg
        viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
        preserveAspectRatio="none"
        role="img"
        aria-label={description(trend, series, unit)}
      >
        {scale && outside(trend, scale, unit, live().now, span).map((band, index) => <Band {...band} key={index} />)}
        {scale &&
          linesOf(trend, scale, unit, live().now, span).map((points) => <polyline points={points} key={points} />)}
      </svg>
      <span class="sparkline-scale" aria-hidden="true">
        {scale && (
          <>
            <span>{decade(scale[1])}</span>
            <span>{unit}</span>
            <span>{decade(scale[0])}</span>
          </>
        )}
      </span>
      <span class="sparkline-time" aria-hidden="true">
        −{age(span)}
      </span>
    </div>
  )
}

/** The whole decades around all values, in the unit; `null` without values. */
function scaleOf(trend: Trend, unit: Unit): [number, number] | null {
  const [low, high] = extent(valuesOf(trend))
  return low === undefined || high === undefined ? null : decades(inUnit(low, unit), inUnit(high, unit))
}

/** The text for those who do not see the line. */
function description(trend: Trend, series: string, unit: Unit): string {
  const [low, high] = extent(valuesOf(trend))
  if (low === undefined || high === undefined) return t.reading.noRecent(series)
  const text = t.reading.recent(series, number(inUnit(low, unit)), number(inUnit(high, unit)), unit)
  const kinds = new Set(stretchesOutside(trend).map(({ kind }) => kind))
  return [text, ...[...kinds].map((kind) => t.reading.atTimes(t.qualities[QUALITIES[kind]]))].join(', ')
}

type Outside = Stretch & { kind: 'over' | 'under'; limit: number }

const QUALITIES = { over: 'overrange', under: 'underrange' } as const

/** The times in which the gauge was outside its range. */
function stretchesOutside(trend: Trend): Outside[] {
  return stretches(trend, BIN_MS).filter((one): one is Outside => one.kind in QUALITIES && one.limit !== null)
}

interface BandProps {
  kind: 'over' | 'under'
  from: number
  to: number
  /** The end of the range. */
  y: number
}

/** The height of a band, and of the least of it that is seen. */
const BAND = 12
const LEAST_BAND = 6

/** A line at the end of the range, and the band outside of it. */
function Band({ kind, from, to, y }: BandProps): JSX.Element {
  const [top, bottom] = kind === 'over' ? [Math.max(0, y - BAND), y] : [y, Math.min(HEIGHT, y + BAND)]
  return (
    <g class={`outside ${kind}`}>
      <rect x={from} y={top} width={to - from} height={bottom - top} />
      <line x1={from} x2={to} y1={y} y2={y} />
    </g>
  )
}

/** The bands of a trend, in units of the picture. */
function outside(trend: Trend, scale: [number, number], unit: Unit, now: number, span: number): BandProps[] {
  const { x, y } = placesOf(scale, unit, now, span)
  return stretchesOutside(trend).flatMap(({ kind, from, to, limit }) => {
    const [left, right] = [Math.max(0, x(from)), Math.min(WIDTH, x(to))]
    const end = kind === 'over' ? Math.max(LEAST_BAND, y(limit)) : Math.min(HEIGHT - LEAST_BAND, y(limit))
    return right > left ? [{ kind, from: left, to: right, y: end }] : []
  })
}

/** Where a time and a pressure are in the picture. */
function placesOf(scale: [number, number], unit: Unit, now: number, span: number) {
  const [bottom, top] = scale.map(Math.log10) as [number, number]
  return {
    x: (time: number): number => WIDTH * (1 - (now - time) / span),
    y: (pa: number): number => 2 + (HEIGHT - 4) * (1 - (Math.log10(inUnit(pa, unit)) - bottom) / (top - bottom)),
  }
}

/** The points of each line between gaps. */
function linesOf(trend: Trend, scale: [number, number], unit: Unit, now: number, span: number): string[] {
  const { times, curves } = join([trend], BIN_MS)
  const means = curves[0]?.mean ?? []
  const { x, y } = placesOf(scale, unit, now, span)
  let line: string[] = []
  const lines = [line]
  times.forEach((time, index) => {
    const mean = means[index]
    if (mean === null) {
      line = []
      lines.push(line)
    } else if (mean !== undefined) line.push(`${x(time).toFixed(1)},${y(mean).toFixed(1)}`)
  })
  // A single sample is drawn as a dot.
  return lines
    .filter(({ length }) => length > 0)
    .map((line) => (line.length === 1 ? [...line, ...line] : line).join(' '))
}

/** The lowest and the highest value; empty if there is none. */
function extent(values: (number | null | undefined)[]): [number, number] | [] {
  const known = values.filter((value) => typeof value === 'number')
  return known.length ? [Math.min(...known), Math.max(...known)] : []
}
