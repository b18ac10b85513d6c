// Trends: the pressures of several series over time, on a logarithmic scale.

import './trends.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { exportAddress, fetchAlarms } from '../../api/calls.ts'
import type { Priority } from '../../api/types.ts'
import { Chart, timePixels } from '../../components/chart.tsx'
import type { Level } from '../../components/chart-overlays.ts'
import { ChartTable } from '../../components/chart-table.tsx'
import { useQuery, useWidth } from '../../components/hooks.ts'
import { curveColours, tokenColour } from '../../components/palette.ts'
import { SampleText } from '../../components/pressure.tsx'
import { SeriesList } from '../../components/series-list.tsx'
import {
  allSeries,
  type ChartData,
  extent,
  rangeAfterKey,
  seriesAt,
  useChartData,
  useTrends,
} from '../../components/use-trends.ts'
import { limitsOf, type PressureLimit } from '../../lib/alarms.ts'
import { DEFAULT_RANGE, isLive, type Range, windowOf, zoomed } from '../../lib/range.ts'
import { decades } from '../../lib/series.ts'
import { inUnit, UNITS, type Unit } from '../../lib/units.ts'
import { useLive, useMoment } from '../../live.ts'
import { useDark, useUnit } from '../../settings.ts'
import { useTrendChoice } from './choice.ts'
import { AlarmLimits } from './limits.tsx'
import { CustomWindow, Toolbar } from './toolbar.tsx'

/** All decades in Pa that gauges of any kind measure. */
const ALL_DECADES: [number, number] = [1e-8, 2e5]

/** Alarms are fetched this often; their limits change only with the station's file. */
const LIMITS_MS = 10_000

/** The colour tokens of the priorities. */
const PRIORITY_COLOURS: Record<Priority, string> = { high: 'bad', medium: 'warn', low: 'accent' }

/** The shortest window that dragging selects. */
const SHORTEST_MS = 2_000

export function Trends(): JSX.Element {
  const live = useLive()
  const unit = useUnit()
  const dark = useDark()
  const all = allSeries(useMoment().gauges)
  const names = all.map(({ series }) => series)
  const [{ series: chosen, range, isAllDecades }, change] = useTrendChoice(names)
  const [box, width] = useWidth()
  /** The position of the cursor, 0 to 1. */
  const [cursor, setCursor] = useState<number | null>(null)
  const query = useTrends(chosen, range, timePixels(width, true))
  const data = useChartData(query.value, range, unit, live.now)
  const events = query.value?.events ?? []
  const window = windowOf(range, live.now)
  const at = cursor === null ? null : window[0] + cursor * (window[1] - window[0])
  const setRange = (range: Range): void => change({ range })
  const colours = curveColours(names, chosen, dark)
  const colourOf = (series: string): string => colours.get(series) ?? 'gray'
  const alarms = useQuery('limits', LIMITS_MS, (signal) => fetchAlarms(signal)).value ?? []
  const limits = limitsOf(alarms, chosen)
  const levels = [...tripLevels(all, data, colourOf, unit), ...limits.map((limit) => limitLevel(limit, unit))]
  const toggle = (series: string): void =>
    change({ series: names.filter((name) => chosen.includes(name) !== (name === series)) })
  return (
    <div class="trends">
      <h1 class="visually-hidden">Trends</h1>
      <Toolbar
        range={range}
        now={live.now}
        isAllDecades={isAllDecades}
        setRange={setRange}
        setAllDecades={(isAllDecades) => change({ isAllDecades })}
      />
      <div class="trend-chart panel" ref={box}>
        <Chart
          label={`Pressures in ${unit} over time. The arrow keys move, plus and minus zoom, Home shows the present.`}
          times={data.times}
          curves={data.curves}
          lines={data.trends.map(({ series }, index) => ({
            name: series,
            colour: colourOf(series),
            stretches: data.stretches[index] ?? [],
          }))}
          window={window}
          scale={isAllDecades ? allDecades(unit) : scaleOf(data, window, unit, levels)}
          log={true}
          unit={unit}
          levels={levels}
          marks={events.map(({ at_ms, text }) => ({ at: at_ms, name: text }))}
          width={width}
          height={chartHeight(width)}
          dark={dark}
          onSelect={(from, to) => setRange({ from, to: Math.max(to, from + SHORTEST_MS) })}
          onZoom={(at, factor) => setRange(zoomed(window, at, factor))}
          onCursor={setCursor}
          onKey={(key) => {
            const next = rangeAfterKey(key, range, live.now, DEFAULT_RANGE)
            if (next) setRange(next)
            return next !== null
          }}
        />
      </div>
      <SeriesList
        all={all}
        chosen={chosen}
        colourOf={colourOf}
        toggle={toggle}
        unit={unit}
        at={at}
        sampleOf={(series, at) => seriesAt(data, series, at)}
        events={near(events, at, window, width)}
      />
      <AlarmLimits limits={limits} unit={unit} />
      <p class="load-error" role="status">
        {query.error}
      </p>
      <div class="bar">
        <CustomWindow window={window} live={isLive(range)} setRange={setRange} />
        <a
          class="button"
          href={exportAddress(chosen, Math.floor(window[0]), Math.ceil(window[1]))}
          download="pressures.csv"
        >
          Save as CSV
        </a>
      </div>
      <ChartTable
        caption="Pressures"
        window={window}
        columns={chosen.map((series) => ({
          name: series,
          cell: (at) => <SampleText sample={seriesAt(data, series, at)} unit={unit} />,
        }))}
      />
    </div>
  )
}

/** The trip levels of the series that are drawn, from the station's file. */
function tripLevels(
  all: ReturnType<typeof allSeries>,
  { trends }: ChartData,
  colourOf: (series: string) => string,
  unit: Unit,
): Level[] {
  return all
    .filter(({ series }) => trends.some((trend) => trend.series === series))
    .flatMap(({ series, gauge }) =>
      gauge.levels.map(({ name, pa }) => ({
        name: `${series}: ${name}`,
        colour: colourOf(series),
        value: inUnit(pa, unit),
      })),
    )
}

function limitLevel({ name, priority, limit }: PressureLimit, unit: Unit): Level {
  return { name, colour: tokenColour(PRIORITY_COLOURS[priority]), value: inUnit(limit, unit) }
}

function chartHeight(width: number): number {
  return width < 600 ? 300 : Math.max(340, Math.min(720, Math.round(innerHeight * 0.52)))
}

const allDecades = (unit: Unit): [number, number] =>
  decades(inUnit(ALL_DECADES[0], unit) * 1.3, inUnit(ALL_DECADES[1], unit))

/** The decades of all values and levels. */
function scaleOf(data: ChartData, window: [number, number], unit: Unit, levels: Level[]): [number, number] {
  const values = [...extent(data, window), ...levels.map(({ value }) => value)].filter(Number.isFinite)
  return values.length ? decades(Math.min(...values), Math.max(...values)) : decades(1 / UNITS[unit], 1e3 / UNITS[unit])
}

/** The width around the cursor in which events are listed, to each side. */
const NEAR_PX = 6

function near<T extends { at_ms: number }>(
  events: T[],
  at: number | null,
  window: [number, number],
  width: number,
): T[] {
  const reach = (NEAR_PX * (window[1] - window[0])) / Math.max(1, width)
  return at === null ? [] : events.filter(({ at_ms }) => Math.abs(at_ms - at) < reach)
}
