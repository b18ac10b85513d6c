// What is drawn beside the curves: beyond-range bands, trip levels, events.

import type uPlot from 'uplot'
import { own } from './colours.ts'
import type { Line } from './chart.tsx'

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

/** The thickness of a lane of marks at the edge, in CSS pixels. */
const LANE_PX = 5
const BAND_PX = 34

const WORDS = { over: 'over range', under: 'under range', invalid: 'not valid' }

/** A stretch beyond range: a pale band and a bar in the colour of the gauge, at the edge beyond which it went. */
export function drawStretches(chart: uPlot, line: Line, lane: number): void {
  const { ctx, bbox } = chart
  const dpr = devicePixelRatio
  ctx.save()
  clip(chart)
  for (const { from, to, what } of line.stretches) {
    const left = Math.max(bbox.left, chart.valToPos(from, 'x', true))
    const right = Math.min(bbox.left + bbox.width, chart.valToPos(to, 'x', true))
    if (right <= left) continue
    const width = Math.max(dpr, right - left)
    const paint = what === 'invalid' ? own('bad') : line.colour
    const depth = what === 'invalid' ? 0 : BAND_PX * dpr
    ctx.fillStyle = `${paint}1c`
    ctx.fillRect(left, what === 'over' ? bbox.top : bbox.top + bbox.height - depth, width, depth)
    ctx.fillStyle = paint
    const height = LANE_PX * dpr
    const place = (height + dpr) * lane
    const top = what === 'over' ? bbox.top + place : bbox.top + bbox.height - height - place
    ctx.fillRect(left, top, width, height)
    label(chart, `${line.name} ${WORDS[what]}`, left + 6 * dpr, what === 'over' ? top + height + 3 * dpr : top - 14 * dpr, width - 12 * dpr)
  }
  ctx.restore()
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
