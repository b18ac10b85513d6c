// Overlays of a chart: bands outside the range, bars without a pressure, levels, named times.

import type uPlot from 'uplot'
import type { Quality } from '../api/types.ts'
import { minorValues } from '../lib/log-grid.ts'
import type { Stretch } from '../lib/series.ts'
import { tokenColour } from './palette.ts'

/** A curve, by its look; its values are in the data of the chart. */
export interface Line {
  name: string
  colour: string
  dashed?: boolean
  /** A value holds until the next one: no line leads from one code to another. */
  stepped?: boolean
  stretches: Stretch[]
}

/** A horizontal line: a trip level, or the limit of an alarm. */
export interface Level {
  name: string
  colour: string
  value: number
}

/** A vertical line with its name: a reference, or the start and end of a rise. */
export interface TimeMark {
  at: number
  name: string
}

/** The height of the bar without a pressure, and of the lane with its name, in CSS pixels. */
const BAR_PX = 5
const LANE_PX = 19

/** The part of the chart that all lanes take at most: many of them are lower. */
const LANES_PART = 1 / 3

/** A band fades out over the first, and is never lower than the second. */
const BAND_PX = 56
const LEAST_BAND_PX = 16

/** The quality that a stretch has. */
export const QUALITIES: Record<Stretch['kind'], Quality> = {
  over: 'overrange',
  under: 'underrange',
  fault: 'fault',
  off: 'off',
  missing: 'missing',
  assumed: 'assumed',
  none: 'stale',
}

/** Whether a stretch is a bar below the plot and not a band at the end of the range. */
export const isBar = ({ kind }: Stretch): boolean => kind !== 'over' && kind !== 'under'

/** The lines with a bar; each has a lane between the plot and the times. */
export const barredLines = (lines: Line[]): Line[] => lines.filter(({ stretches }) => stretches.some(isBar))

const laneHeight = (count: number, height: number): number => Math.min(LANE_PX, (LANES_PART * height) / count)

/** The height of all lanes of a chart of this height, in CSS pixels. */
export function lanesHeight(lines: Line[], height: number): number {
  const { length } = barredLines(lines)
  return length === 0 ? 0 : Math.ceil(length * laneHeight(length, height))
}

/** The top and bottom of a lane, in CSS pixels below the upper edge of the plot. */
export function laneEdges(chart: uPlot, lines: Line[], line: Line): [number, number] {
  const barred = barredLines(lines)
  const height = laneHeight(barred.length, chart.height)
  const top = chart.over.clientHeight + height * barred.indexOf(line)
  return [top, top + height]
}

/** Draws the stretches of all lines; the bars of each line have a lane of their own. */
export function drawAllStretches(chart: uPlot, lines: Line[]): void {
  chart.ctx.save()
  clip(chart, lanesHeight(lines, chart.height))
  for (const line of lines) {
    const [, bottom] = laneEdges(chart, lines, line)
    for (const stretch of line.stretches) drawStretch(chart, line.colour, stretch, bottom)
  }
  chart.ctx.restore()
}

/**
 * Draws a stretch without a pressure. Outside the range: a shaded band that begins at the end of the range. Otherwise a bar below the
 * plot in the colour of the curve: filled for a fault, hollow while the gauge is off, a dashed line while nothing was recorded. In the
 * plot it would be read as a pressure.
 */
function drawStretch(chart: uPlot, colour: string, stretch: Stretch, laneBottom: number): void {
  const { ctx, bbox } = chart
  const dpr = devicePixelRatio
  const left = Math.max(bbox.left, chart.valToPos(stretch.from, 'x', true))
  const right = Math.min(bbox.left + bbox.width, chart.valToPos(stretch.to, 'x', true))
  if (right <= left) return
  const [top, bottom] = edges(chart, stretch, laneBottom).map((y) => bbox.top + y * dpr) as [number, number]
  ctx.fillStyle = ctx.strokeStyle = colour
  ctx.lineWidth = dpr
  if (!isBar(stretch)) ctx.fillStyle = faded(ctx, colour, stretch.kind === 'over' ? [bottom, top] : [top, bottom])
  if (stretch.kind === 'none') {
    ctx.setLineDash([4 * dpr, 3 * dpr])
    stroke(ctx, left, (top + bottom) / 2, right, (top + bottom) / 2)
    ctx.setLineDash([])
  } else if (isBar(stretch) && stretch.kind !== 'fault')
    ctx.strokeRect(left, top + dpr / 2, right - left, bottom - top - dpr)
  else ctx.fillRect(left, top, Math.max(dpr, right - left), bottom - top)
}

/** A gradient from the end of the range outwards. */
function faded(ctx: CanvasRenderingContext2D, colour: string, [from, to]: [number, number]): CanvasGradient {
  const paint = ctx.createLinearGradient(0, from, 0, to)
  paint.addColorStop(0, `${colour}59`)
  paint.addColorStop(1, `${colour}00`)
  return paint
}

/** The top and bottom of a stretch, in CSS pixels below the upper edge of the plot. */
export function edges(chart: uPlot, stretch: Stretch, laneBottom: number): [number, number] {
  const { kind, limit } = stretch
  const height = chart.over.clientHeight
  if (isBar(stretch) || limit === null) return [laneBottom - BAR_PX - 1, laneBottom - 1]
  const y = chart.valToPos(limit, 'y')
  if (kind === 'over') {
    const end = Math.max(y, LEAST_BAND_PX)
    return [Math.max(0, end - BAND_PX), end]
  }
  const end = Math.min(y, height - LEAST_BAND_PX)
  return [end, Math.min(height, end + BAND_PX)]
}

/** The numbers between the powers of ten, paler than these. */
export function drawMinorGrid(chart: uPlot): void {
  const { ctx, bbox, scales } = chart
  const { min, max } = scales.y ?? {}
  if (min == null || max == null) return
  ctx.save()
  ctx.lineWidth = devicePixelRatio
  ctx.globalAlpha = 0.6
  ctx.strokeStyle = tokenColour('grid')
  for (const value of minorValues(min, max, bbox.height / devicePixelRatio)) {
    const y = Math.round(chart.valToPos(value, 'y', true)) + 0.5
    stroke(ctx, bbox.left, y, bbox.left + bbox.width, y)
  }
  ctx.restore()
}

/** The unit of the pressure axis, above its numbers. */
export function drawUnit({ ctx, bbox }: uPlot, unit: string): void {
  ctx.save()
  ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`
  ctx.textBaseline = 'top'
  ctx.textAlign = 'right'
  ctx.fillStyle = tokenColour('muted')
  ctx.fillText(unit, bbox.left - 6 * devicePixelRatio, 0)
  ctx.restore()
}

/** Draws the lines of levels and times, without their names. */
export function drawMarks(chart: uPlot, levels: Level[], marks: TimeMark[]): void {
  const { ctx, bbox } = chart
  const dpr = devicePixelRatio
  ctx.save()
  clip(chart)
  ctx.lineWidth = dpr
  ctx.setLineDash([6 * dpr, 4 * dpr])
  for (const { colour, value } of levels) {
    const y = Math.round(chart.valToPos(value, 'y', true)) + 0.5
    ctx.strokeStyle = colour
    stroke(ctx, bbox.left, y, bbox.left + bbox.width, y)
  }
  ctx.lineWidth = 2 * dpr
  ctx.setLineDash([])
  ctx.strokeStyle = tokenColour('accent')
  for (const { at } of marks) {
    const x = Math.round(chart.valToPos(at, 'x', true)) + 0.5
    stroke(ctx, x, bbox.top, x, bbox.top + bbox.height)
  }
  ctx.restore()
}

function stroke(ctx: CanvasRenderingContext2D, fromX: number, fromY: number, toX: number, toY: number): void {
  ctx.beginPath()
  ctx.moveTo(fromX, fromY)
  ctx.lineTo(toX, toY)
  ctx.stroke()
}

/** Nothing is drawn outside the plot and this many CSS pixels below it. */
function clip({ ctx, bbox }: uPlot, below = 0): void {
  ctx.beginPath()
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height + below * devicePixelRatio)
  ctx.clip()
}
