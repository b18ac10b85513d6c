// Trends of the points of slaves: the points that a page offers, and their curves in charts with one axis each.

import type { Gauge, Point, PointTrend, RecordedPoint, Trend } from '../api/types.ts'
import { FAULT, GAP, sampleAt, VALID, withRecent } from './series.ts'

/** A point that the page offers. */
export interface OfferedPoint {
  /** Its name in the address of the page and in the list: `turbo.speed`. */
  key: string
  slave: string
  point: Point
  gauge: Gauge
}

/** All points of all slaves, in the order of the station. */
export function offeredPoints(gauges: Gauge[]): OfferedPoint[] {
  return gauges
    .filter(({ kind }) => kind === 'slave')
    .flatMap((gauge) =>
      gauge.parameters.map((point) => ({
        key: `${gauge.name}.${point.target}`,
        slave: gauge.name,
        point,
        gauge,
      })),
    )
}

/** A point of a station of an archive. */
export interface StationPoint {
  /** Its name in the address of the page and in the list: `hall-1/turbo.speed`. */
  key: string
  station: string
  slave: string
  name: string
}

type Named = Pick<RecordedPoint, 'slave' | 'name'>

/** Each point of an archive once, by name: of a point in several units the page shows the unit of the last value. */
export function stationPoints(archived: { station: string; point: Named }[]): StationPoint[] {
  const all = new Map<string, StationPoint>()
  for (const { station, point } of archived) {
    const key = `${station}/${point.slave}.${point.name}`
    all.set(key, { key, station, slave: point.slave, name: point.name })
  }
  return [...all.values()].sort((one, other) => one.key.localeCompare(other.key))
}

/** The curve of a point, in its unit. A code has no mean: its line is the last code of each pixel. */
export function curveOf({ point, ...trend }: PointTrend): Trend {
  const { start_ms, low, high, last, qualities } = trend
  const mean = point.kind === 'code' ? trend.last : trend.mean
  // The value before a fault or a gap in the same pixel is not held.
  const held = last.map((value, index) => ((qualities[index] ?? 0) & (FAULT | GAP) ? null : value))
  return { series: `${point.slave}.${point.name}`, start_ms, low, high, mean, last: held, qualities }
}

/** A curve up to the value that the slave shows now: the recorder keeps a value that does not change once a minute. */
export function untilNow(curve: Trend, present: number | null, now: number): Trend {
  return present === null ? curve : withRecent(curve, [{ at: now, pa: present, bits: VALID }])
}

/** The points of one chart: numbers with the same unit. A number without a unit and a code have a chart of their own. */
export interface PointGroup {
  /** The unit; empty without one. */
  unit: string
  isCode: boolean
  trends: PointTrend[]
}

export function pointGroups(trends: PointTrend[]): PointGroup[] {
  const groups: PointGroup[] = []
  for (const trend of trends) {
    const isCode = trend.point.kind === 'code'
    const unit = trend.point.unit ?? ''
    const same = groups.find((group) => !isCode && !group.isCode && unit !== '' && group.unit === unit)
    if (same) same.trends.push(trend)
    else groups.push({ unit, isCode, trends: [trend] })
  }
  return groups
}

/** The ends of the axis: all numbers in a window, with a margin. */
export function linearScale(curves: Trend[], [from, to]: [number, number]): [number, number] {
  let [low, high] = [Infinity, -Infinity]
  for (const trend of curves) {
    trend.start_ms.forEach((start, index) => {
      if (start < from || start > to) return
      low = Math.min(low, trend.low[index] ?? Infinity)
      high = Math.max(high, trend.high[index] ?? -Infinity)
    })
  }
  if (low > high) return [0, 1]
  const margin = (high - low || Math.abs(high) || 1) * 0.08
  return [low - margin, high + margin]
}

/** A number of a point: six digits, which is more than a chart shows. */
export function shortNumber(value: number): string {
  const rounded = Number(value.toPrecision(6))
  const size = Math.abs(rounded)
  return rounded === 0 || (size >= 1e-4 && size < 1e6) ? String(rounded) : rounded.toExponential()
}

/** The recorded value of a point at a time, in words; `null` without one. A code without a text is a number. */
export function pointAt(trend: PointTrend, at: number, binMs: number): string | null {
  const value = sampleAt(curveOf(trend), at, binMs)?.mean ?? null
  if (value === null) return null
  if (trend.point.kind === 'code') return trend.texts.find(({ number }) => number === value)?.text ?? shortNumber(value)
  return [shortNumber(value), trend.point.unit].filter(Boolean).join(' ')
}
