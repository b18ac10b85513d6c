// The names of curves at their ends: a colour alone does not say which curve is which.

import type uPlot from 'uplot'
import { apart } from '../lib/curves.ts'
import type { Value } from '../lib/series.ts'
import { type Line, marksHeight, outline } from './chart-overlays.ts'

/** The height of a name, in CSS pixels. */
const NAME_PX = 13

/** Draws the name of each curve at its last value in the window, below the names of `marks` times. A single curve needs none. */
export function drawCurveNames(chart: uPlot, lines: Line[], times: number[], means: Value[][], marks: number): void {
  if (lines.length < 2) return
  const { bbox } = chart
  const gap = NAME_PX * devicePixelRatio
  const ends = lines.flatMap((line, index) => {
    const at = endOf(times, means[index] ?? [], chart.scales.x?.max ?? Infinity)
    if (at === null || at[0] < (chart.scales.x?.min ?? -Infinity)) return []
    return [{ line, x: chart.valToPos(at[0], 'x', true), y: chart.valToPos(at[1], 'y', true) - gap }]
  })
  const bounds: [number, number] = [bbox.top + marksHeight(marks), bbox.top + bbox.height - gap]
  const places = apart(
    ends.map(({ y }) => y),
    gap,
    bounds,
  )
  for (const [index, { line, x }] of ends.entries()) drawName(chart, line, x, places[index] ?? bounds[0])
}

/** The time and value at which a curve ends, at most at `latest`. */
function endOf(times: number[], mean: Value[], latest: number): [number, number] | null {
  for (let index = times.length - 1; index >= 0; index -= 1) {
    const [at, value] = [times[index], mean[index]]
    if (at !== undefined && at <= latest && typeof value === 'number') return [at, value]
  }
  return null
}

/** The name, to the left of `x` so that it stays in the chart, with a pale edge over what is below it. */
function drawName({ ctx, bbox }: uPlot, { name, colour }: Line, x: number, y: number): void {
  const dpr = devicePixelRatio
  ctx.save()
  ctx.font = `600 ${11 * dpr}px system-ui, sans-serif`
  ctx.textBaseline = 'top'
  ctx.textAlign = 'left'
  const left = Math.max(bbox.left, Math.min(x, bbox.left + bbox.width - 4 * dpr) - ctx.measureText(name).width)
  outline(ctx, name, left, y)
  ctx.fillStyle = colour
  ctx.fillText(name, left, y)
  ctx.restore()
}
