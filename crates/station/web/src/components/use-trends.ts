// The trends of several series in a window of time, fetched for the pixels of the chart and again for every zoom.

import { useEffect, useMemo, useState } from 'preact/hooks'
import { fetchEvents, fetchPointTrend, fetchTrend } from '../api/calls.ts'
import { RequestError } from '../api/request.ts'
import type { Gauge, PointTrend, StationEvent, Trend } from '../api/types.ts'
import type { OfferedPoint } from '../lib/point-trends.ts'
import { aligned, isLive, moved, type Range, windowOf, zoomed } from '../lib/range.ts'
import {
  type Curve,
  join,
  type Sample,
  type Stretch,
  sampleAt,
  stretches,
  type Value,
  withoutData,
  withRecent,
} from '../lib/series.ts'
import { inUnit, type Unit } from '../lib/units.ts'
import { recentSamples, useLive } from '../live.ts'
import { type Query, useQuery } from './hooks.ts'

/** A live window is fetched this often, unless a pixel is longer. */
const REFRESH_MS = 5_000

/** A window is fetched when it has not changed for this long: a wheel turns in many small steps. */
const SETTLED_MS = 150

const MOST_EVENTS = 200

export interface FetchedTrends {
  trends: Trend[]
  events: StationEvent[]
  /** The length of a pixel. */
  binMs: number
  /** The time that was fetched, in milliseconds. */
  window: [number, number]
}

/** The value, after it has not changed for a while. */
function useSettled<T>(value: T, key: string): T {
  const [settled, setSettled] = useState(value)
  useEffect(() => {
    const timer = setTimeout(() => setSettled(value), SETTLED_MS)
    return () => clearTimeout(timer)
  }, [key])
  return settled
}

/** Fetches the trend of a series. */
export type TrendSource = (
  series: string,
  from: number,
  to: number,
  pixels: number,
  signal: AbortSignal,
) => Promise<Trend>

/** Fetches again when `version` changes: the number of notes that the page made, or the source of the trends. */
export function useTrends(
  names: string[],
  range: Range,
  pixels: number,
  version: number | string = 0,
  trendOf: TrendSource = fetchTrend,
): Query<FetchedTrends> {
  const settled = useSettled({ names, range, pixels, version }, JSON.stringify([names, range, pixels, version]))
  const live = useLive()
  const period = isLive(range) ? Math.max(REFRESH_MS, range.last / Math.max(1, pixels)) : null
  const query = useQuery<FetchedTrends | null>(JSON.stringify(settled), period, async (signal) => {
    const { names, range, pixels } = settled
    // The width of the page is not known yet: nothing has been fetched.
    if (pixels === 0) return null
    const { from, to, binMs, count } = aligned(windowOf(range, live.now), pixels)
    const [events, ...trends] = await Promise.all([
      fetchEvents(from, to, MOST_EVENTS, signal),
      ...names.map((name) => trendOf(name, from, to, count, signal)),
    ])
    return { trends, events, binMs, window: [from, to] }
  })
  return { ...query }
}

/** The fetched trends of points. A point of which nothing was recorded yet has none. */
export interface FetchedPoints {
  trends: PointTrend[]
  binMs: number
}

/** Fetches the trend of a point. */
export type PointTrendSource<P> = (
  point: P,
  from: number,
  to: number,
  pixels: number,
  signal: AbortSignal,
) => Promise<PointTrend>

/** The trend of a point of this station. */
export const stationPointTrend: PointTrendSource<OfferedPoint> = ({ slave, point }, from, to, pixels, signal) =>
  fetchPointTrend(slave, point.target, from, to, pixels, signal)

/** The trends of points in the same pixels as those of pressures. */
export function usePointTrends<P extends { key: string }>(
  points: P[],
  range: Range,
  pixels: number,
  trendOf: PointTrendSource<P>,
): Query<FetchedPoints> {
  const key = JSON.stringify([points.map(({ key }) => key), range, pixels])
  const settled = useSettled({ points, range, pixels, key }, key)
  const live = useLive()
  const period = isLive(range) ? Math.max(REFRESH_MS, range.last / Math.max(1, pixels)) : null
  return useQuery(settled.key, settled.points.length === 0 ? null : period, async (signal) => {
    const { points, range, pixels } = settled
    if (pixels === 0) return { trends: [], binMs: 1 }
    const { from, to, binMs, count } = aligned(windowOf(range, live.now), pixels)
    const fetched = points.map(async (point) => {
      try {
        return await trendOf(point, from, to, count, signal)
      } catch (error) {
        if (error instanceof RequestError && error.status === 404) return null
        throw error
      }
    })
    return { trends: (await Promise.all(fetched)).filter((trend) => trend !== null), binMs }
  })
}

/** The data of a chart. */
export interface ChartData {
  /** In Pa. */
  trends: Trend[]
  binMs: number
  times: number[]
  /** In the chosen unit. */
  curves: Curve[]
  stretches: Stretch[][]
}

/** The fetched trends; in a live range with the samples that were received since. */
export function useChartData(fetched: FetchedTrends | null, range: Range, unit: Unit, now: number): ChartData {
  const [from, to] = fetched?.window ?? [0, 0]
  const isMoving = isLive(range) || to > now
  const second = isMoving ? Math.floor(now / 1000) : 0
  return useMemo(() => {
    const trends = (fetched?.trends ?? []).map((trend) =>
      isLive(range) ? withRecent(trend, recentSamples(trend.series)) : trend,
    )
    const binMs = fetched?.binMs ?? 1
    const { times, curves } = join(trends, binMs)
    return {
      trends,
      binMs,
      times,
      curves: curves.map((curve) => curveIn(curve, unit)),
      stretches: trends.map((trend) => {
        const all = [...stretches(trend, binMs), ...withoutData(trend, binMs, [from, isMoving ? now : to])]
        return all.map((stretch) => stretchIn(stretch, unit))
      }),
    }
  }, [fetched, unit, second, isMoving])
}

function curveIn({ low, high, mean }: Curve, unit: Unit): Curve {
  const converted = (values: Value[]): Value[] => values.map((pa) => (typeof pa === 'number' ? inUnit(pa, unit) : pa))
  return { low: converted(low), high: converted(high), mean: converted(mean) }
}

function stretchIn(stretch: Stretch, unit: Unit): Stretch {
  return { ...stretch, limit: stretch.limit === null ? null : inUnit(stretch.limit, unit) }
}

/** The lowest and the highest value in a window, with the ends of ranges; infinite if there is none. */
export function extent(data: ChartData, [from, to]: [number, number]): [number, number] {
  let [low, high] = [Infinity, -Infinity]
  data.times.forEach((time, index) => {
    if (time < from || time > to) return
    for (const curve of data.curves) {
      low = Math.min(low, curve.low[index] ?? Infinity)
      high = Math.max(high, curve.high[index] ?? -Infinity)
    }
  })
  for (const { from: start, to: end, limit } of data.stretches.flat()) {
    if (limit === null || end < from || start > to) continue
    low = Math.min(low, limit)
    high = Math.max(high, limit)
  }
  return [low, high]
}

/** Whether nothing of the fetched trends can be drawn. */
export const hasNoValues = ({ curves, stretches }: ChartData): boolean =>
  curves.every(({ mean }) => mean.every((value) => typeof value !== 'number')) && stretches.flat().length === 0

/** The sample of a series at a time, in Pa. */
export function seriesAt(data: ChartData, series: string, at: number): Sample | null {
  const trend = data.trends.find((trend) => trend.series === series)
  return trend ? sampleAt(trend, at, data.binMs) : null
}

/** The range after a key; `null` if the chart does not use the key. */
export function rangeAfterKey(key: string, range: Range, now: number, home: Range): Range | null {
  const window = windowOf(range, now)
  const middle = (window[0] + window[1]) / 2
  switch (key) {
    case 'ArrowLeft':
      return moved(window, -0.2)
    case 'ArrowRight':
      return moved(window, 0.2)
    case '+':
      return zoomed(window, middle, 0.5)
    case '-':
      return zoomed(window, middle, 2)
    case 'Home':
      return home
    default:
      return null
  }
}

/** All series with their gauges, in the order of the station. */
export function allSeries(gauges: Gauge[]): { series: string; gauge: Gauge }[] {
  return gauges.flatMap((gauge) => gauge.readings.map(({ series }) => ({ series, gauge })))
}
