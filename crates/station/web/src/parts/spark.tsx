// The last ten minutes of a gauge, as small as a line can be. Gaps are gaps.

import type { JSX } from 'preact'
import { trend, type Trend } from '../api.ts'
import { live, tail } from '../live.ts'
import { aligned } from '../pure/range.ts'
import { decades, join, withTail } from '../pure/series.ts'
import { useAsked } from './use.ts'

const WIDTH = 240
const HEIGHT = 44
const SPAN_MS = 600_000
const AGAIN_MS = 60_000

export function Spark({ series, dim }: { series: string; dim: boolean }): JSX.Element {
  const asked = useAsked(series, AGAIN_MS, (signal) => {
    const now = Math.round(live().now)
    const { from, to, count } = aligned([now - SPAN_MS, now], WIDTH)
    return trend(series, from, to, count, signal)
  })
  const lines = asked.value ? drawn(withTail(asked.value, tail(series)), live().now) : []
  const words = asked.value?.start_ms.length
    ? `The last ten minutes of ${series}`
    : 'Nothing was recorded in the last ten minutes'
  return (
    <svg
      class={dim ? 'spark dim' : 'spark'}
      viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
      preserveAspectRatio="none"
      role="img"
      aria-label={words}
    >
      {lines.map((points) => (
        <polyline points={points} />
      ))}
    </svg>
  )
}

/** A line for each stretch without a gap. */
function drawn(trend: Trend, now: number): string[] {
  const binMs = SPAN_MS / WIDTH
  const { times, curves } = join([trend], binMs)
  const means = curves[0]!.mean
  const [low, high] = decades(...extent(means))
  const [bottom, top] = [Math.log10(low), Math.log10(high)]
  const x = (time: number): number => WIDTH * (1 - (now - time) / SPAN_MS)
  const y = (pa: number): number => 2 + (HEIGHT - 4) * (1 - (Math.log10(pa) - bottom) / (top - bottom))
  const lines: string[][] = [[]]
  times.forEach((time, place) => {
    const mean = means[place]
    if (mean === null) lines.push([])
    else if (mean !== undefined) lines[lines.length - 1]!.push(`${x(time).toFixed(1)},${y(mean).toFixed(1)}`)
  })
  return lines
    .filter(({ length }) => length > 0)
    .map((points) => (points.length === 1 ? [...points, ...points] : points).join(' '))
}

function extent(values: (number | null | undefined)[]): [number, number] {
  const known = values.filter((value): value is number => typeof value === 'number')
  return known.length ? [Math.min(...known), Math.max(...known)] : [1, 1]
}
