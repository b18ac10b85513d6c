// The names in a chart: of levels, of times, of curves, of bands and bars. A colour alone does not say which curve is which.

import type uPlot from 'uplot'
import {
  along,
  firstFree,
  type Profile,
  placesAtCurve,
  placesAtLine,
  profileOf,
  type Rect,
  type Size,
} from '../lib/name-places.ts'
import type { Stretch, Value } from '../lib/series.ts'
import { t } from '../texts/texts.ts'
import {
  barredLines,
  edges,
  isBar,
  type Level,
  type Line,
  laneEdges,
  QUALITIES,
  type TimeMark,
} from './chart-overlays.ts'
import { tokenColour } from './palette.ts'

/** What has a name. */
export interface Named {
  lines: Line[]
  levels: Level[]
  marks: TimeMark[]
  times: number[]
  /** The values of each line. */
  means: Value[][]
}

interface Name {
  text: string
  colour: string
  isBold?: boolean
}

/** The height of a name in pixels, and that of the row in which a mark has its name. */
const HEIGHT = 12
const MARK_ROW = 14

/** The least distance between two names in a row, in pixels. */
const APART = 8

/** The height that the bars take at the bottom of a lane. */
const BAR_ROOM = 6

/** Where the rows of the marks begin below the upper edge. */
const MARKS = 6

/** The height of the names of `count` marks, in pixels. */
export const marksHeight = (count: number): number => (count === 0 ? 0 : MARKS + MARK_ROW * count)

/** Where a name stands that has no free place: nowhere, over a curve, or over anything. */
type Otherwise = 'nowhere' | 'over-curves' | 'anywhere'

/** Places names one after the other, each where none of the former is and no curve passes. */
class Layout {
  readonly plot: Size
  private readonly rects: Rect[] = []

  constructor(
    private readonly chart: uPlot,
    private readonly curves: Profile[],
  ) {
    this.plot = plotOf(chart)
  }

  /** Keeps names away from something that is drawn. */
  keepFree(rect: Rect): void {
    this.rects.push(rect)
  }

  size({ text, isBold = false }: Name): Size {
    const { ctx } = this.chart
    ctx.font = font(isBold)
    return { width: ctx.measureText(text).width / devicePixelRatio, height: HEIGHT }
  }

  /** Draws a name at the first free place; without one, at the first that `otherwise` permits. */
  draw(name: Name, places: Rect[], otherwise: Otherwise): void {
    const { rects, curves, plot } = this
    const place =
      firstFree(places, { rects, curves }, plot) ??
      (otherwise === 'nowhere' ? null : firstFree(places, { rects, curves: [] }, plot)) ??
      (otherwise === 'anywhere' ? firstFree(places, { rects: [], curves: [] }, plot) : null)
    if (!place) return
    this.rects.push({ ...place, left: place.left - APART, width: place.width + 2 * APART })
    write(this.chart, name, place)
  }
}

export function drawNames(chart: uPlot, named: Named): void {
  const profiles = named.means.map((mean) => profileOf(pointsOf(chart, named.times, mean), plotOf(chart).width))
  const layout = new Layout(chart, profiles)
  chart.ctx.save()
  for (const { value } of named.levels)
    layout.keepFree({ left: 0, top: chart.valToPos(value, 'y'), width: layout.plot.width, height: 1 })
  for (const [row, mark] of named.marks.entries()) drawMarkName(chart, layout, mark, row)
  for (const level of named.levels) drawLevelName(chart, layout, level)
  if (named.lines.length > 1)
    for (const [index, line] of named.lines.entries()) drawCurveName(layout, line, profiles[index] ?? [])
  for (const line of named.lines) drawBandNames(chart, layout, line)
  for (const line of barredLines(named.lines)) drawLaneName(chart, line, laneEdges(chart, named.lines, line))
  chart.ctx.restore()
}

/** The size of the plot in CSS pixels. */
const plotOf = ({ over }: uPlot): Size => ({ width: over.clientWidth, height: over.clientHeight })

/** The points of a curve in CSS pixels. A value that is `undefined` does not break the curve. */
function pointsOf(chart: uPlot, times: number[], mean: Value[]): ([number, number] | null)[] {
  return times.flatMap((at, index): ([number, number] | null)[] => {
    const value = mean[index]
    if (value === undefined) return []
    return [value === null ? null : [chart.valToPos(at, 'x'), chart.valToPos(value, 'y')]]
  })
}

/** Each mark has its name in a row of its own, to the right of its line or to the left where there is no room: marks may be close to each other. */
function drawMarkName(chart: uPlot, layout: Layout, { at, name }: TimeMark, row: number): void {
  const x = chart.valToPos(at, 'x')
  if (x < 0 || x > layout.plot.width) return
  layout.keepFree({ left: x - 1, top: 0, width: 2, height: layout.plot.height })
  const text = { text: name, colour: tokenColour('accent') }
  const size = layout.size(text)
  const top = MARKS + MARK_ROW * row
  const lefts = [x + 6, x - 6 - size.width]
  layout.draw(
    text,
    lefts.map((left) => ({ left, top, ...size })),
    'anywhere',
  )
}

function drawLevelName(chart: uPlot, layout: Layout, { name, colour, value }: Level): void {
  const y = chart.valToPos(value, 'y')
  if (y < 0 || y > layout.plot.height) return
  const text = { text: name, colour }
  layout.draw(text, placesAtLine(y, layout.size(text), layout.plot), 'over-curves')
}

function drawCurveName(layout: Layout, { name, colour }: Line, profile: Profile): void {
  const text = { text: name, colour, isBold: true }
  layout.draw(text, placesAtCurve(profile, layout.size(text), layout.plot), 'over-curves')
}

/** The longest visible band of each kind has its name: many of one kind would repeat it all over the chart. */
function drawBandNames(chart: uPlot, layout: Layout, line: Line): void {
  const length = (stretch: Stretch): number => {
    const [left, right] = sides(chart, layout, stretch)
    return right - left
  }
  const bands = line.stretches.filter((one) => !isBar(one))
  for (const kind of new Set(bands.map(({ kind }) => kind))) {
    const [longest] = bands.filter((one) => one.kind === kind).sort((one, other) => length(other) - length(one))
    if (longest) drawBandName(chart, layout, line, longest)
  }
}

function drawBandName(chart: uPlot, layout: Layout, { name, colour }: Line, stretch: Stretch): void {
  const [left, right] = sides(chart, layout, stretch)
  if (right <= left) return
  const [top, bottom] = edges(chart, stretch, 0)
  const text = { text: `${name} ${t.qualities[QUALITIES[stretch.kind]]}`, colour }
  const size = layout.size(text)
  const inside = along(left + 4, right - size.width - 4)
  const beside = [right + 4, left - 4 - size.width]
  const places = rowsOf(stretch, top, bottom).flatMap((row) =>
    [...inside, ...beside].map((at) => ({ left: at, top: row, ...size })),
  )
  layout.draw(text, places, 'nowhere')
}

/** The name of a lane and its kinds of bars, above them at the left: `bpg400 6 fault, no data`. A low lane has its name over its bars. */
function drawLaneName(chart: uPlot, { name, colour, stretches }: Line, [top, bottom]: [number, number]): void {
  const kinds = new Set(stretches.filter(isBar).map(({ kind }) => t.qualities[QUALITIES[kind]]))
  const above = Math.max(top, bottom - HEIGHT - BAR_ROOM)
  write(chart, { text: `${name} ${[...kinds].join(', ')}`, colour }, { left: 4, top: above })
}

/** The rows in which the name of a band may stand: at the end of the range first, then further outside, then inside. */
function rowsOf({ kind }: Stretch, top: number, bottom: number): number[] {
  const row = HEIGHT + 1
  return kind === 'over' ? [bottom - row, bottom - 2 * row, bottom + 2] : [top + 2, top + 2 + row, top - row]
}

/** The left and right edge of a stretch within the plot. */
function sides(chart: uPlot, { plot }: Layout, { from, to }: Stretch): [number, number] {
  return [Math.max(0, chart.valToPos(from, 'x')), Math.min(plot.width, chart.valToPos(to, 'x'))]
}

const font = (isBold: boolean): string => `${isBold ? '600 ' : ''}${11 * devicePixelRatio}px system-ui, sans-serif`

/** Writes a name with a pale edge, over what is below it. */
function write(
  { ctx, bbox }: uPlot,
  { text, colour, isBold = false }: Name,
  { left, top }: Pick<Rect, 'left' | 'top'>,
): void {
  const dpr = devicePixelRatio
  const [x, y] = [bbox.left + left * dpr, bbox.top + top * dpr]
  ctx.font = font(isBold)
  ctx.textBaseline = 'top'
  ctx.textAlign = 'left'
  ctx.setLineDash([])
  ctx.lineWidth = 3 * dpr
  ctx.lineJoin = 'round'
  ctx.strokeStyle = tokenColour('panel')
  ctx.strokeText(text, x, y)
  ctx.fillStyle = colour
  ctx.fillText(text, x, y)
}
