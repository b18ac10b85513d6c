// Curves of several series in a window of time, fetched for as many pixels as there are, and again for every zoom.

import type { JSX } from 'preact'
import { useEffect, useMemo, useState } from 'preact/hooks'
import { events, trend, type Gauge, type Happening, type Trend } from '../api.ts'
import { tail, useLive } from '../live.ts'
import { aligned, isLive, moved, windowOf, zoomed, type Range } from '../pure/range.ts'
import { join, stretches, valueAt, withTail } from '../pure/series.ts'
import { UNITS, type Unit } from '../pure/units.ts'
import { useAsked, type Asked } from './use.ts'

/** How often what goes on is fetched again, unless a pixel is longer. */
const AGAIN_MS = 5_000

/** A window is fetched when it has stood for so long: a wheel turns in many small steps. */
const SETTLED_MS = 150

const MOST_EVENTS = 200

export interface Fetched {
  trends: Trend[]
  happenings: Happening[]
  binMs: number
}

/** The range, after it has stood still for a moment. */
export function useSettled<T>(value: T, key: string): T {
  const [settled, setSettled] = useState(value)
  useEffect(() => {
    const timer = setTimeout(() => setSettled(value), SETTLED_MS)
    return () => clearTimeout(timer)
  }, [key])
  return settled
}

export function useTrends(names: string[], range: Range, pixels: number): Asked<Fetched> {
  const key = JSON.stringify([names, range, pixels])
  const settled = useSettled({ names, range, pixels }, key)
  const live = useLive()
  const often = isLive(range) ? Math.max(AGAIN_MS, range.last / Math.max(1, pixels)) : null
  return useAsked(JSON.stringify(settled), often, async (signal) => {
    const { names, range, pixels } = settled
    if (pixels === 0) return { trends: [], happenings: [], binMs: 1 }
    const { from, to, binMs, count } = aligned(windowOf(range, live.now), pixels)
    const [happenings, ...trends] = await Promise.all([
      events(from, to, MOST_EVENTS, signal),
      ...names.map((name) => trend(name, from, to, count, signal)),
    ])
    return { trends, happenings, binMs }
  })
}

/** What is drawn: the record, and in a live range what was seen since. */
export function useDrawn(fetched: Fetched | null, range: Range, unit: Unit, now: number): Drawn {
  const second = isLive(range) ? Math.floor(now / 1000) : 0
  return useMemo(() => {
    const trends = (fetched?.trends ?? []).map((one) => (isLive(range) ? withTail(one, tail(one.series)) : one))
    const binMs = fetched?.binMs ?? 1
    const { times, curves } = join(trends, binMs)
    const shown = (values: (number | null | undefined)[]): (number | null | undefined)[] =>
      values.map((pa) => (typeof pa === 'number' ? pa / UNITS[unit] : pa))
    return {
      trends,
      binMs,
      times,
      curves: curves.map(({ low, high, mean }) => ({ low: shown(low), high: shown(high), mean: shown(mean) })),
      stretches: trends.map((one) =>
        stretches(one, binMs).map((stretch) => ({
          ...stretch,
          limit: stretch.limit === null ? null : stretch.limit / UNITS[unit],
        })),
      ),
    }
  }, [fetched, unit, second, isLive(range)])
}

export interface Drawn {
  trends: Trend[]
  binMs: number
  times: number[]
  curves: ReturnType<typeof join>['curves']
  stretches: ReturnType<typeof stretches>[]
}

/** The lowest and the highest value of what is drawn in a window, ends of ranges included. */
export function extent(drawn: Drawn, [from, to]: [number, number]): [number, number] {
  let [low, high] = [Infinity, -Infinity]
  drawn.times.forEach((time, place) => {
    if (time < from || time > to) return
    for (const curve of drawn.curves) {
      low = Math.min(low, curve.low[place] ?? Infinity)
      high = Math.max(high, curve.high[place] ?? -Infinity)
    }
  })
  for (const { from: start, to: end, limit } of drawn.stretches.flat()) {
    if (limit === null || end < from || start > to) continue
    low = Math.min(low, limit)
    high = Math.max(high, limit)
  }
  return [low, high]
}

/** What a series shows at a time. */
export function readAt(drawn: Drawn, series: string, at: number): { mean: number | null; bits: number } | null {
  const found = drawn.trends.find((one) => one.series === series)
  return found ? valueAt(found, at, drawn.binMs) : null
}

/** What keys do to a range; nothing if the key means nothing. */
export function keyed(key: string, range: Range, now: number, home: Range): Range | null {
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

/** Every series of every gauge, in the order of the station. */
export function allSeries(gauges: Gauge[]): { series: string; gauge: Gauge }[] {
  return gauges.flatMap((gauge) => gauge.readings.map(({ series }) => ({ series, gauge })))
}

export function Busy({ asked }: { asked: Asked<unknown> }): JSX.Element {
  return (
    <p class="busy" role="status">
      {asked.error ?? ''}
    </p>
  )
}
