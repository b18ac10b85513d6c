// The chart of the trends page: curves, trip levels, alarm limits and events.

import type { JSX } from 'preact'
import type { Gauge, Priority } from '../../api/types.ts'
import { Chart, timePixels } from '../../components/chart.tsx'
import type { Level } from '../../components/chart-overlays.ts'
import { tokenColour } from '../../components/palette.ts'
import { type ChartData, extent, rangeAfterKey } from '../../components/use-trends.ts'
import { isActive, type PressureLimit } from '../../lib/alarms.ts'
import { DEFAULT_RANGE, type Range, SHORTEST_MS, windowOf, zoomed } from '../../lib/range.ts'
import { decades } from '../../lib/series.ts'
import { inUnit, UNITS, type Unit } from '../../lib/units.ts'
import { useLive } from '../../live.ts'
import { useDark, useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'
import type { TrendChoice } from './choice.ts'

interface Props {
  /** All series with their gauges. */
  all: { series: string; gauge: Gauge }[]
  choice: TrendChoice
  data: ChartData
  limits: PressureLimit[]
  width: number
  colourOf: (series: string) => string
  setRange: (range: Range) => void
  setCursor: (position: number | null) => void
  /** Sets the reference; `null` sets it at the cursor. */
  setReference: (at: number | null) => void
}

export const trendPixels = (width: number): number => timePixels(width, true)

export function TrendChart(props: Props): JSX.Element {
  const { all, choice, data, limits, width, colourOf, setRange, setCursor, setReference } = props
  const { now } = useLive()
  const unit = useUnit()
  const dark = useDark()
  const window = windowOf(choice.range, now)
  const levels = [...tripLevels(all, data, colourOf, unit), ...limits.map((limit) => limitLevel(limit, unit))]
  const handleKey = (key: string): boolean => {
    if (key.toLowerCase() === 'r') {
      setReference(null)
      return true
    }
    const next = rangeAfterKey(key, choice.range, now, DEFAULT_RANGE)
    if (next) setRange(next)
    return next !== null
  }
  return (
    <Chart
      label={t.trends.chart(unit)}
      times={data.times}
      curves={data.curves}
      lines={data.trends.map(({ series }, index) => ({
        name: series,
        colour: colourOf(series),
        stretches: data.stretches[index] ?? [],
      }))}
      window={window}
      scale={choice.isAllDecades ? allDecades(unit) : scaleOf(data, window, unit, levels)}
      log={true}
      unit={unit}
      levels={levels}
      marks={choice.reference === null ? [] : [{ at: choice.reference, name: t.trends.reference }]}
      width={width}
      height={heightOf(width)}
      dark={dark}
      onSelect={(from, to) => setRange({ from, to: Math.max(to, from + SHORTEST_MS) })}
      onZoom={(at, factor) => setRange(zoomed(window, at, factor))}
      onCursor={setCursor}
      onPress={setReference}
      onKey={handleKey}
    />
  )
}

/** The trip levels of the series that are drawn, from the station's file. */
function tripLevels(
  all: Props['all'],
  { trends }: ChartData,
  colourOf: (series: string) => string,
  unit: Unit,
): Level[] {
  const drawn = all.filter(({ series }) => trends.some((trend) => trend.series === series))
  return drawn.flatMap(({ series, gauge }) =>
    gauge.levels.map(({ name, pa }) => ({
      name: `${series}: ${name}`,
      colour: colourOf(series),
      value: inUnit(pa, unit),
    })),
  )
}

/** The colour tokens of the priorities. */
const PRIORITY_COLOURS: Record<Priority, string> = { high: 'bad', medium: 'warn', low: 'low' }

/** The limit of an alarm; without colour unless the alarm is active. */
function limitLevel({ name, priority, state, limit }: PressureLimit, unit: Unit): Level {
  const token = isActive({ state }) ? PRIORITY_COLOURS[priority] : 'muted'
  return { name, colour: tokenColour(token), value: inUnit(limit, unit) }
}

const heightOf = (width: number): number =>
  width < 600 ? 300 : Math.max(340, Math.min(720, Math.round(innerHeight * 0.52)))

/** All decades in Pa that gauges of any kind measure. */
const ALL_DECADES: [number, number] = [1e-8, 2e5]

const allDecades = (unit: Unit): [number, number] =>
  decades(inUnit(ALL_DECADES[0], unit) * 1.3, inUnit(ALL_DECADES[1], unit))

/** The decades of all values and levels. */
function scaleOf(data: ChartData, window: [number, number], unit: Unit, levels: Level[]): [number, number] {
  const values = [...extent(data, window), ...levels.map(({ value }) => value)].filter(Number.isFinite)
  return values.length ? decades(Math.min(...values), Math.max(...values)) : decades(1 / UNITS[unit], 1e3 / UNITS[unit])
}
