// What is drawn beside the curves: beyond-range bands, trip levels, events.

import type uPlot from 'uplot'
import { own } from './colours.ts'
import type { Line } from './chart.tsx'
import type { Stretch } from '../pure/series.ts'

export interface Level {
  name: string
  colour: string
  value: number
}

export interface Mark {
  at: number
  name: string
  /** Drawn strongly: where a rise begins and ends. */
  strong?: boolean
}

/** The thickness of a bar at the edge, in CSS pixels. */
const BAR_PX = 5

/** A band fades out over so many, and is seen however near to the edge a range ends. */
const BAND_PX = 56
const LEAST_BAND_PX = 16

const WORDS = { over: 'over range', under: 'under range', invalid: 'not valid' }

/** All of them; bars lie above each other. */
export function drawAllStretches(chart: uPlot, lines: Line[]): void {
  let lane = 0
  for (const line of lines) {
    drawStretches(chart, line, lane)
    if (line.stretches.some(({ what }) => what === 'invalid')) lane += 1
  }
}

/** Stretches without a pressure. Beyond range: a pale band from the end of the range on, for it is somewhere in there. Not
 *  valid: a bar at the bottom. */
function drawStretches(chart: uPlot, line: Line, lane: number): void {
  const { ctx, bbox } = chart
  const dpr = devicePixelRatio
  ctx.save()
  clip(chart)
  for (const stretch of line.stretches) {
    const left = Math.max(bbox.left, chart.valToPos(stretch.from, 'x', true))
    const right = Math.min(bbox.left + bbox.width, chart.valToPos(stretch.to, 'x', true))
    if (right <= left) continue
    const [top, bottom] = edges(chart, stretch, lane)
    ctx.fillStyle =
      stretch.what === 'invalid'
        ? own('bad')
        : faded(ctx, line.colour, stretch.what === 'over' ? [bottom, top] : [top, bottom])
    ctx.fillRect(left, top, Math.max(dpr, right - left), bottom - top)
    const words = `${line.name} ${WORDS[stretch.what]}`
    const y = stretch.what === 'over' ? bottom - 13 * dpr : stretch.what === 'under' ? top + 2 * dpr : top - 14 * dpr
    label(
      chart,
      words,
      left + 130 * dpr,
      y,
      right - left - 136 * dpr,
      stretch.what === 'invalid' ? own('bad') : line.colour,
    )
  }
  ctx.restore()
}

/** A colour that is strongest where a range ends. */
function faded(ctx: CanvasRenderingContext2D, colour: string, [from, to]: [number, number]): CanvasGradient {
  const paint = ctx.createLinearGradient(0, from, 0, to)
  paint.addColorStop(0, `${colour}59`)
  paint.addColorStop(1, `${colour}00`)
  return paint
}

/** Where a stretch begins and ends from top to bottom. */
function edges({ bbox, valToPos }: uPlot, { what, limit }: Stretch, lane: number): [number, number] {
  const dpr = devicePixelRatio
  const bottom = bbox.top + bbox.height
  if (what === 'invalid' || limit === null) {
    const place = bottom - (BAR_PX + 1) * dpr * lane
    return [place - BAR_PX * dpr, place]
  }
  const y = valToPos(limit, 'y', true)
  const [least, most] = [LEAST_BAND_PX * dpr, BAND_PX * dpr]
  if (what === 'over') {
    const end = Math.max(y, bbox.top + least)
    return [Math.max(bbox.top, end - most), end]
  }
  const end = Math.min(y, bottom - least)
  return [end, Math.min(bottom, end + most)]
}

export function drawMarks(chart: uPlot, levels: Level[], marks: Mark[]): void {
  chart.ctx.save()
  clip(chart)
  levels.forEach((level) => drawLevel(chart, level))
  marks.forEach((mark) => drawMark(chart, mark))
  chart.ctx.restore()
}

function drawLevel(chart: uPlot, level: Level): void {
  const { ctx, bbox } = chart
  const dpr = devicePixelRatio
  const y = Math.round(chart.valToPos(level.value, 'y', true)) + 0.5
  if (y < bbox.top || y > bbox.top + bbox.height) return
  ctx.strokeStyle = level.colour
  ctx.lineWidth = dpr
  ctx.setLineDash([6 * dpr, 4 * dpr])
  stroke(ctx, bbox.left, y, bbox.left + bbox.width, y)
  label(chart, level.name, bbox.left + 8 * dpr, y - 15 * dpr, bbox.width, level.colour)
}

function drawMark(chart: uPlot, mark: Mark): void {
  const { ctx, bbox } = chart
  const dpr = devicePixelRatio
  const x = Math.round(chart.valToPos(mark.at, 'x', true)) + 0.5
  if (x < bbox.left || x > bbox.left + bbox.width) return
  ctx.strokeStyle = own(mark.strong ? 'accent' : 'muted')
  ctx.lineWidth = mark.strong ? 2 * dpr : dpr
  ctx.setLineDash(mark.strong ? [] : [2 * dpr, 4 * dpr])
  stroke(ctx, x, bbox.top, x, bbox.top + bbox.height)
  if (mark.strong) {
    // To the right of its line, or to the left where there is no room.
    ctx.font = `${11 * dpr}px system-ui, sans-serif`
    const width = ctx.measureText(mark.name).width + 6 * dpr
    const left = x + width > bbox.left + bbox.width ? x - width : x + 6 * dpr
    return label(chart, mark.name, left, bbox.top + 6 * dpr, width, own('accent'))
  }
  ctx.fillStyle = own('muted')
  ctx.beginPath()
  ctx.moveTo(x - 4 * dpr, bbox.top + bbox.height)
  ctx.lineTo(x + 4 * dpr, bbox.top + bbox.height)
  ctx.lineTo(x, bbox.top + bbox.height - 7 * dpr)
  ctx.fill()
}

function stroke(ctx: CanvasRenderingContext2D, fromX: number, fromY: number, toX: number, toY: number): void {
  ctx.beginPath()
  ctx.moveTo(fromX, fromY)
  ctx.lineTo(toX, toY)
  ctx.stroke()
}

function label(chart: uPlot, text: string, x: number, y: number, room: number, colour = own('muted')): void {
  const { ctx } = chart
  ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`
  ctx.textBaseline = 'top'
  ctx.textAlign = 'left'
  ctx.fillStyle = colour
  if (ctx.measureText(text).width <= room) ctx.fillText(text, x, y)
}

function clip({ ctx, bbox }: uPlot): void {
  ctx.beginPath()
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height)
  ctx.clip()
}
