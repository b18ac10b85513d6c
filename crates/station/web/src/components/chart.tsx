// Curves over time with uPlot: logarithmic or linear, with bands, levels, named times and a cursor. The page gives it the data and
// reacts to zoom, selection, cursor and keys.

import './chart.css'
import type { JSX } from 'preact'
import { useEffect, useRef } from 'preact/hooks'
import uPlot from 'uplot'
import 'uplot/dist/uPlot.min.css'
import { useLanguage } from '../language.ts'
import { decade, number } from '../lib/format.ts'
import { digitOf, namedValues } from '../lib/log-grid.ts'
import { shortNumber } from '../lib/point-trends.ts'
import type { Curve } from '../lib/series.ts'
import { drawNames } from './chart-names.ts'
import {
  drawAllStretches,
  drawMarks,
  drawMinorGrid,
  drawUnit,
  type Level,
  type Line,
  lanesHeight,
  type TimeMark,
} from './chart-overlays.ts'
import { tokenColour } from './palette.ts'

export interface ChartProps {
  /** The accessible name. */
  label: string
  times: number[]
  /** Values in `unit`. */
  curves: Curve[]
  lines: Line[]
  window: [number, number]
  scale: [number, number]
  log: boolean
  /** A linear chart below a logarithmic one: their times are above each other. */
  isBelow?: boolean
  unit: string
  levels?: Level[]
  marks?: TimeMark[]
  width: number
  height: number
  dark: boolean
  onSelect: (from: number, to: number) => void
  onZoom?: (at: number, factor: number) => void
  /** The position of the cursor, 0 at the left edge to 1 at the right: the time under it moves on. */
  onCursor?: (position: number | null) => void
  /** A press without a drag at this time. */
  onPress?: (at: number) => void
  /** Whether the page uses the key. */
  onKey?: (key: string) => boolean
}

/** The width of the axis of values, and the margin at the other edge. */
const AXIS_PX = { log: 58, linear: 84 }
const EDGE_PX = 24

/** The height above the plot: the unit stands above the highest number, which reaches into it. */
const UNIT_PX = 24

/** Where the plot area of a logarithmic chart begins and ends, in pixels from its edges. */
export const PLOT_EDGES = { left: AXIS_PX.log, right: EDGE_PX }

/** The width of the plot area in pixels. */
export function timePixels(width: number, log: boolean): number {
  return Math.max(0, width - (log ? AXIS_PX.log : AXIS_PX.linear) - EDGE_PX)
}

/** The height of a label on the pressure axis. */
const LABEL_PX = 18

export function Chart(props: ChartProps): JSX.Element {
  const box = useRef<HTMLDivElement>(null)
  const plot = useRef<uPlot | null>(null)
  const latest = useRef(props)
  latest.current = props
  const language = useLanguage()
  const structure = `${language} ${props.dark} ${props.log} ${props.unit} ${props.lines.map((line) => line.colour + line.name + line.stepped).join()}`
  useEffect(() => {
    if (props.width === 0 || !box.current) return
    const chart = new uPlot(options(latest, language), data(latest.current), box.current)
    plot.current = chart
    const wheel = (event: WheelEvent): void => zoomed(event, chart, latest.current)
    chart.over.addEventListener('wheel', wheel, { passive: false })
    // The chart stops the click that ends a drag.
    chart.over.addEventListener('click', (event) =>
      latest.current.onPress?.(
        Math.round(chart.posToVal(event.clientX - chart.over.getBoundingClientRect().left, 'x')),
      ),
    )
    return () => {
      chart.destroy()
      plot.current = null
    }
  }, [structure, props.width === 0])
  useEffect(() => plot.current?.setSize({ width: props.width, height: props.height }), [props.width, props.height])
  const lanesPx = lanesHeight(props.lines, props.height)
  useEffect(() => plot.current?.redraw(true, true), [lanesPx])
  useEffect(() => {
    const chart = plot.current
    chart?.batch(() => {
      chart.setData(data(props), false)
      chart.setScale('x', { min: props.window[0], max: props.window[1] })
      chart.setScale('y', { min: props.scale[0], max: props.scale[1] })
    })
  })
  const onKeyDown = (event: KeyboardEvent): void => {
    const step = CURSOR_STEPS[event.key]
    if (event.shiftKey && step && plot.current) {
      event.preventDefault()
      stepCursor(plot.current, step)
      return
    }
    if (!event.ctrlKey && !event.metaKey && !event.altKey && props.onKey?.(event.key)) event.preventDefault()
  }
  return (
    <div
      class="chart"
      ref={box}
      style={{ height: `${props.height}px` }}
      // biome-ignore lint/a11y/noNoninteractiveTabindex: the chart takes keys
      tabIndex={0}
      role="application"
      aria-label={props.label}
      data-from={props.window[0]}
      data-to={props.window[1]}
      data-points={props.times.length}
      data-unit={props.unit}
      onKeyDown={onKeyDown}
    />
  )
}

/** Keys that move the cursor together with Shift, as parts of the width. */
const CURSOR_STEPS: Record<string, number> = { ArrowLeft: -0.01, ArrowRight: 0.01 }

/** Moves the cursor; the first step begins at the middle. */
function stepCursor(chart: uPlot, part: number): void {
  const { clientWidth: width, clientHeight: height } = chart.over
  const { left = -1 } = chart.cursor
  const from = left < 0 ? width / 2 : left
  chart.setCursor({ left: Math.max(0, Math.min(width - 1, from + part * width)), top: height / 2 })
}

function zoomed(event: WheelEvent, chart: uPlot, props: ChartProps): void {
  if (!props.onZoom) return
  event.preventDefault()
  const at = chart.posToVal(event.clientX - chart.over.getBoundingClientRect().left, 'x')
  props.onZoom(at, 2 ** (Math.max(-150, Math.min(150, event.deltaY)) / 200))
}

/** Times first, then lowest, highest and mean values of each curve. */
function data(props: ChartProps): uPlot.AlignedData {
  return [props.times, ...props.curves.flatMap(({ low, high, mean }) => [low, high, mean])] as uPlot.AlignedData
}

function options(latest: { current: ChartProps }, language: string): uPlot.Options {
  const { width, height, log, isBelow = false, lines } = latest.current
  const series = lines.flatMap(({ colour, dashed, stepped }): uPlot.Series[] => {
    const steps = stepped ? uPlot.paths.stepped?.({ align: 1 }) : undefined
    const usual = { points: { show: false }, ...(steps ? { paths: steps } : {}) }
    const hidden = { stroke: 'transparent', width: 0, ...usual }
    return [hidden, hidden, { stroke: colour, width: 1.8, dash: dashed ? [8, 5] : [], ...usual }]
  })
  const bands = lines.map(
    ({ colour }, index): uPlot.Band => ({ series: [3 * index + 2, 3 * index + 1], fill: `${colour}38` }),
  )
  return {
    width,
    height,
    ms: 1,
    fmtDate: (form) => uPlot.fmtDate(form, dateNames(language)),
    legend: { show: false },
    padding: [UNIT_PX, EDGE_PX, 0, 0],
    scales: {
      x: { time: true, range: () => latest.current.window },
      y: { distr: log ? 3 : 1, range: () => latest.current.scale },
    },
    axes: [lanes(latest), timeAxis(), isBelow ? numberAxis() : pressureAxis(log)],
    series: [{}, ...series],
    bands,
    cursor: { drag: { x: true, y: false, setScale: false }, points: { show: false }, y: false },
    hooks: hooks(latest),
  }
}

/** The short names of the months; the axis has no other names. */
function dateNames(language: string): uPlot.DateNames {
  const month = new Intl.DateTimeFormat(language, { month: 'short' })
  const MMM = Array.from({ length: 12 }, (_, index) => month.format(new Date(2026, index, 1)))
  return { MMMM: MMM, MMM, WWWW: [], WWW: [] }
}

const FONT = '12px system-ui, sans-serif'

/** The room between the plot and the times for the bars without a pressure. */
const lanes = (latest: { current: ChartProps }): uPlot.Axis => ({
  size: () => lanesHeight(latest.current.lines, latest.current.height),
  splits: () => [],
  values: () => [],
  grid: { show: false },
  ticks: { show: false },
})

function timeAxis(): uPlot.Axis {
  // Hours from 0 to 24; the date is below where it changes.
  const values: uPlot.Axis.DynamicValues | (string | number | null)[][] = [
    [365 * 86_400_000, '{YYYY}', null, null, null, null, null, null, 1],
    [28 * 86_400_000, '{MMM}', '\n{YYYY}', null, null, null, null, null, 1],
    [86_400_000, '{D} {MMM}', '\n{YYYY}', null, null, null, null, null, 1],
    [3_600_000, '{HH}:{mm}', '\n{D} {MMM}', null, '\n{D} {MMM}', null, null, null, 1],
    [60_000, '{HH}:{mm}', '\n{D} {MMM}', null, '\n{D} {MMM}', null, null, null, 1],
    [1_000, '{HH}:{mm}:{ss}', '\n{D} {MMM}', null, '\n{D} {MMM}', null, null, null, 1],
    [1, '{ss}.{fff}', '\n{HH}:{mm}', null, '\n{HH}:{mm}', null, null, null, 1],
  ]
  return {
    // The library takes each axis but the first for one of values.
    scale: 'x',
    side: 2,
    stroke: tokenColour('muted'),
    font: FONT,
    grid: { stroke: tokenColour('grid'), width: 1 },
    ticks: { show: false },
    size: 44,
    space: 80,
    values,
  }
}

const valueAxis = (): uPlot.Axis => ({
  stroke: tokenColour('muted'),
  font: FONT,
  grid: { stroke: tokenColour('grid'), width: 1 },
  ticks: { show: false },
  size: AXIS_PX.log,
})

/** Short numbers, so that the plot begins where that of the pressures begins. */
const numberAxis = (): uPlot.Axis => ({ ...valueAxis(), values: (_, splits) => splits.map(shortNumber) })

function pressureAxis(log: boolean): uPlot.Axis {
  const axis = valueAxis()
  if (!log) return { ...axis, values: (_, splits) => splits.map(number), size: AXIS_PX.linear }
  return {
    ...axis,
    splits: (chart, _, low, high) => namedValues(low, high, chart.bbox.height / devicePixelRatio, LABEL_PX),
    filter: (_, splits) => splits,
    values: (_, splits) => splits.map((value) => digitOf(value)?.toString() ?? decade(value)),
  }
}

/** The names are drawn last, over all curves. */
const nameAll = (chart: uPlot, { lines, levels = [], marks = [], times, curves }: ChartProps): void =>
  drawNames(chart, { lines, levels, marks, times, means: curves.map(({ mean }) => mean) })

function hooks(latest: { current: ChartProps }): uPlot.Hooks.Arrays {
  return {
    drawAxes: [
      (chart) => latest.current.log && drawMinorGrid(chart),
      (chart) => drawAllStretches(chart, latest.current.lines),
    ],
    draw: [
      (chart) => drawMarks(chart, latest.current.levels ?? [], latest.current.marks ?? []),
      (chart) => drawUnit(chart, latest.current.unit),
      (chart) => nameAll(chart, latest.current),
    ],
    setSelect: [
      (chart) => {
        const { left, width } = chart.select
        if (width < 4) return
        latest.current.onSelect(Math.round(chart.posToVal(left, 'x')), Math.round(chart.posToVal(left + width, 'x')))
        chart.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false)
      },
    ],
    setCursor: [
      (chart) => {
        const { left = -1 } = chart.cursor
        latest.current.onCursor?.(left < 0 ? null : left / chart.over.clientWidth)
      },
    ],
  }
}
