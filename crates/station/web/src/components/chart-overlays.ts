// Overlays of a chart: bands outside the range, levels, named times.

import type uPlot from 'uplot'
import type { Quality } from '../api/types.ts'
import { freePlace, namePlaces, type Rect } from '../lib/level-names.ts'
import type { Stretch } from '../lib/series.ts'
import { t } from '../texts/texts.ts'
import { tokenColour } from './palette.ts'

/** A curve, by its look; its values are in the data of the chart. */
export interface Line {
  name: string
  colour: string
  dashed?: boolean
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
const LANE_PX = 13

/** The room at the left edge that the names of levels take. */
const LEVELS_PX = 130

/** A band fades out over the first, and is never lower than the second. */
const BAND_PX = 56
const LEAST_BAND_PX = 16

/** The quality that a stretch has. */
const QUALITIES: Record<Stretch['kind'], Quality> = {
  over: 'overrange',
  under: 'underrange',
  fault: 'fault',
  off: 'off',
  missing: 'missing',
  assumed: 'assumed',
}

/** Whether a stretch is a bar at the bottom and not a band at the end of the range. */
const isBar = ({ kind }: Stretch): boolean => kind !== 'over' && kind !== 'under'

/**
 * Draws the stretches of all lines; the bars of several lines lie above each other. Their names do not meet those of the levels, which are
 * drawn later.
 */
export function drawAllStretches(chart: uPlot, lines: Line[], levels: Level[]): void {
  let lane = 0
  const taken: Rect[] = levelNames(chart, levels).map(({ name }) => name)
  for (const line of lines) {
    drawStretches(chart, line, lane, taken)
    if (line.stretches.some(isBar)) lane += 1
  }
}

/**
 * Draws stretches without a pressure. Outside the range: a shaded band that begins at the end of the range. Otherwise a bar at the
 * bottom in the colour of the curve: filled for a fault, hollow while the gauge is off.
 */
function drawStretches(chart: uPlot, line: Line, lane: number, taken: Rect[]): void {
  const { ctx, bbox } = chart
  const dpr = devicePixelRatio
  ctx.save()
  clip(chart)
  for (const stretch of line.stretches) {
    const left = Math.max(bbox.left, chart.valToPos(stretch.from, 'x', true))
    const right = Math.min(bbox.left + bbox.width, chart.valToPos(stretch.to, 'x', true))
    if (right <= left) continue
    const [top, bottom] = edges(chart, stretch, lane)
    ctx.fillStyle = ctx.strokeStyle = line.colour
    ctx.lineWidth = dpr
    if (!isBar(stretch))
      ctx.fillStyle = faded(ctx, line.colour, stretch.kind === 'over' ? [bottom, top] : [top, bottom])
    if (isBar(stretch) && stretch.kind !== 'fault')
      ctx.strokeRect(left, top + dpr / 2, right - left, bottom - top - dpr)
    else ctx.fillRect(left, top, Math.max(dpr, right - left), bottom - top)
    const text = `${line.name} ${t.qualities[QUALITIES[stretch.kind]]}`
    ctx.font = NAME_FONT()
    const width = ctx.measureText(text).width
    const xs = namesAt(bbox, left, right, width, isBar(stretch))
    const ys = rowsOf(stretch, top, bottom).filter((y) => y >= bbox.top && y + NAME_PX * dpr <= bbox.top + bbox.height)
    // Two names over each other could not be read.
    const place = freePlace(xs, ys, { width, height: NAME_PX * dpr }, taken)
    if (place === null) continue
    label(chart, text, place.left, place.top, width, line.colour)
    taken.push(place)
  }
  ctx.restore()
}

/** The height of a name, in CSS pixels. */
const NAME_PX = 12

/** The rows in which the name of a stretch may stand: at the end of the range first, then further outside, then inside. */
function rowsOf({ kind }: Stretch, top: number, bottom: number): number[] {
  const row = (NAME_PX + 1) * devicePixelRatio
  const gap = 2 * devicePixelRatio
  if (kind === 'over') return [bottom - row, bottom - 2 * row, bottom + gap]
  if (kind === 'under') return [top + gap, top + gap + row, top - row]
  return [top - 3 * devicePixelRatio]
}

/**
 * Where the name of a stretch may begin, the best place first: in a band that is long enough, behind the stretch, before it, at its start.
 * A band has its name beside the names of levels if it is long enough for that.
 */
function namesAt(bbox: uPlot.BBox, left: number, right: number, width: number, isBar: boolean): number[] {
  const gap = 4 * devicePixelRatio
  const inside = Math.max(left + gap, bbox.left + LEVELS_PX * devicePixelRatio)
  const end = right - gap - width
  return [
    ...(!isBar && inside <= end ? [inside] : []),
    ...(right + gap + width <= bbox.left + bbox.width ? [right + gap] : []),
    ...(left - gap - width >= bbox.left ? [left - gap - width] : []),
    ...(!isBar && end > left + gap ? [end] : []),
    left + gap,
  ]
}

/** A gradient from the end of the range outwards. */
function faded(ctx: CanvasRenderingContext2D, colour: string, [from, to]: [number, number]): CanvasGradient {
  const paint = ctx.createLinearGradient(0, from, 0, to)
  paint.addColorStop(0, `${colour}59`)
  paint.addColorStop(1, `${colour}00`)
  return paint
}

/** The top and bottom of a stretch. */
function edges({ bbox, valToPos }: uPlot, stretch: Stretch, lane: number): [number, number] {
  const { kind, limit } = stretch
  const dpr = devicePixelRatio
  const bottom = bbox.top + bbox.height
  if (isBar(stretch) || limit === null) {
    const y = bottom - (LANE_PX * lane + 4) * dpr
    return [y - BAR_PX * dpr, y]
  }
  const y = valToPos(limit, 'y', true)
  const [least, most] = [LEAST_BAND_PX * dpr, BAND_PX * dpr]
  if (kind === 'over') {
    const end = Math.max(y, bbox.top + least)
    return [Math.max(bbox.top, end - most), end]
  }
  const end = Math.min(y, bottom - least)
  return [end, Math.min(bottom, end + most)]
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

export function drawMarks(chart: uPlot, levels: Level[], marks: TimeMark[]): void {
  chart.ctx.save()
  clip(chart)
  drawLevels(chart, levels)
  for (const [row, mark] of marks.entries()) drawMark(chart, mark, row)
  chart.ctx.restore()
}

/** The levels within the scale, with their height and the place of their name. */
function levelNames(chart: uPlot, levels: Level[]): { level: Level; y: number; name: Rect }[] {
  const { ctx, bbox } = chart
  const dpr = devicePixelRatio
  ctx.font = NAME_FONT()
  const shown = levels
    .map((level) => ({ ...level, y: Math.round(chart.valToPos(level.value, 'y', true)) + 0.5 }))
    .filter(({ y }) => y >= bbox.top && y <= bbox.top + bbox.height)
  const places = namePlaces(
    shown.map(({ name, y }) => ({ y: (y - bbox.top) / dpr, width: ctx.measureText(name).width / dpr })),
  )
  return shown.map(({ y, ...level }, index) => {
    const { x: left, y: top } = places[index] ?? { x: 0, y: 0 }
    const width = ctx.measureText(level.name).width
    return { level, y, name: { left: bbox.left + left * dpr, top: bbox.top + top * dpr, width, height: NAME_PX * dpr } }
  })
}

function drawLevels(chart: uPlot, levels: Level[]): void {
  const { ctx, bbox } = chart
  const dpr = devicePixelRatio
  const all = levelNames(chart, levels)
  ctx.lineWidth = dpr
  ctx.setLineDash([6 * dpr, 4 * dpr])
  for (const { level, y, name } of all) {
    ctx.strokeStyle = level.colour
    stroke(ctx, bbox.left, y, bbox.left + bbox.width, y)
    label(chart, level.name, name.left, name.top, bbox.left + bbox.width - name.left, level.colour)
  }
}

/** Where the names of marks begin below the upper edge, and the height of a row, in CSS pixels. */
const MARKS_PX = 6
const MARK_ROW_PX = 14

/** The height of the names of `count` marks, in pixels of the canvas. */
export const marksHeight = (count: number): number =>
  count === 0 ? 0 : (MARKS_PX + MARK_ROW_PX * count) * devicePixelRatio

/** Each mark has its name in a row of its own: marks may be close to each other. */
function drawMark(chart: uPlot, mark: TimeMark, row: number): void {
  const { bbox } = chart
  const x = Math.round(chart.valToPos(mark.at, 'x', true)) + 0.5
  if (x < bbox.left || x > bbox.left + bbox.width) return
  const { ctx } = chart
  const dpr = devicePixelRatio
  ctx.strokeStyle = tokenColour('accent')
  ctx.lineWidth = 2 * dpr
  ctx.setLineDash([])
  stroke(ctx, x, bbox.top, x, bbox.top + bbox.height)
  ctx.font = `${11 * dpr}px system-ui, sans-serif`
  const width = ctx.measureText(mark.name).width + 6 * dpr
  // To the right of the line, or to the left where there is no room.
  const left = x + width > bbox.left + bbox.width ? x - width : x + 6 * dpr
  label(chart, mark.name, left, bbox.top + (MARKS_PX + MARK_ROW_PX * row) * dpr, width, tokenColour('accent'))
}

function stroke(ctx: CanvasRenderingContext2D, fromX: number, fromY: number, toX: number, toY: number): void {
  ctx.beginPath()
  ctx.moveTo(fromX, fromY)
  ctx.lineTo(toX, toY)
  ctx.stroke()
}

const NAME_FONT = (): string => `${11 * devicePixelRatio}px system-ui, sans-serif`

function label(chart: uPlot, text: string, x: number, y: number, room: number, colour = tokenColour('muted')): void {
  const { ctx } = chart
  ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`
  ctx.textBaseline = 'top'
  ctx.textAlign = 'left'
  ctx.fillStyle = colour
  if (ctx.measureText(text).width > room) return
  outline(ctx, text, x, y)
  ctx.fillText(text, x, y)
}

/** A pale edge around a text, over the lines and bars below it. */
export function outline(ctx: CanvasRenderingContext2D, text: string, x: number, y: number): void {
  ctx.save()
  ctx.setLineDash([])
  ctx.lineWidth = 3 * devicePixelRatio
  ctx.lineJoin = 'round'
  ctx.strokeStyle = tokenColour('panel')
  ctx.strokeText(text, x, y)
  ctx.restore()
}

function clip({ ctx, bbox }: uPlot): void {
  ctx.beginPath()
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height)
  ctx.clip()
}
