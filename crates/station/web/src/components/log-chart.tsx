// A chart on logarithmic axes: the grid of its decades, and a picture that is drawn for the pixels it has.

import './log-chart.css'
import type { ComponentChildren, JSX } from 'preact'
import { useLayoutEffect, useRef, useState } from 'preact/hooks'
import { decade } from '../lib/format.ts'
import { areNamed, isNamed, minorDigits } from '../lib/log-grid.ts'
import { type Axes, decadesOf, place } from '../lib/pump-downs.ts'
import { inUnit, UNITS } from '../lib/units.ts'
import { useUnit } from '../settings.ts'

/** The margins around the axes, with room for their names. */
const [LEFT, RIGHT, TOP, BOTTOM] = [48, 16, 28, 40]

/** The width before the first measurement. */
const USUAL_WIDTH = 760

/** Between the names of two decades of time, in pixels. */
const NAME_WIDTH = 36

/** The room of a digit between two decades of time, and between two of pressure. */
const [DIGIT_WIDTH, DIGIT_HEIGHT] = [26, 18]

/** The numbers 2 to 9 of the decades between two exponents. */
const minorsOf = ([from, to]: [number, number], decadePx: number): { value: number; digit: number }[] =>
  decadesOf([from, to - 1]).flatMap((exponent) =>
    minorDigits(decadePx).map((digit) => ({ value: digit * 10 ** exponent, digit })),
  )

interface Props {
  /** The height in pixels, with the margins. */
  height: number
  /** The picture in words. */
  label: string
  /** What is drawn between the axes, for their size in pixels. */
  children: (width: number, height: number) => ComponentChildren
}

/** One unit of the picture is one pixel on the screen, so texts have the same size on a wide screen and on a phone. */
export function LogChart({ height, label, children }: Props): JSX.Element {
  const frame = useRef<HTMLDivElement>(null)
  const [width, setWidth] = useState(USUAL_WIDTH)
  useLayoutEffect(() => {
    const element = frame.current
    if (!element) return
    const measure = (): void => setWidth(Math.max(LEFT + RIGHT + NAME_WIDTH, Math.round(element.clientWidth)))
    measure()
    const observer = new ResizeObserver(measure)
    observer.observe(element)
    return () => observer.disconnect()
  }, [])
  return (
    <div ref={frame} class="log-chart">
      <svg viewBox={`0 0 ${width} ${height}`} height={height} role="img" aria-label={label}>
        <g transform={`translate(${LEFT} ${TOP})`}>{children(width - LEFT - RIGHT, height - TOP - BOTTOM)}</g>
      </svg>
    </div>
  )
}

interface GridProps {
  axes: Axes
  width: number
  height: number
}

/** The decades of time, and the name of the axis. */
export function TimeGrid({ axes, width, height, name }: GridProps & { name: string }): JSX.Element {
  const all = decadesOf(axes.s)
  const decadePx = width / (axes.s[1] - axes.s[0])
  const hasDigits = areNamed(decadePx, DIGIT_WIDTH)
  const each = Math.max(1, Math.ceil((all.length * NAME_WIDTH) / width))
  return (
    <>
      {minorsOf(axes.s, decadePx).map(({ value, digit }) => {
        const x = place(value, axes.s) * width
        return (
          <g key={`s${value}`}>
            <line class="grid minor" x1={x} x2={x} y1={0} y2={height} />
            {hasDigits && isNamed(digit) && (
              <text x={x} y={height + 16} text-anchor="middle">
                {digit}
              </text>
            )}
          </g>
        )
      })}
      {all.map((exponent, position) => {
        const x = place(10 ** exponent, axes.s) * width
        return (
          <g key={`s${exponent}`}>
            <line class="grid" x1={x} x2={x} y1={0} y2={height} />
            {position % each === 0 && (
              <text x={x} y={height + 16} text-anchor="middle">
                {decade(10 ** exponent)}
              </text>
            )}
          </g>
        )
      })}
      <text x={width / 2} y={height + 34} text-anchor="middle">
        {name}
      </text>
    </>
  )
}

/** The decades of pressure in the unit of the user, and the unit. */
export function PressureGrid({ axes, width, height }: GridProps): JSX.Element {
  const unit = useUnit()
  // The axis has decades of Pa; a unit moves its labels.
  const [from, to] = axes.pa.map((exponent) => Math.log10(inUnit(10 ** exponent, unit))) as [number, number]
  const decadePx = height / (axes.pa[1] - axes.pa[0])
  const hasDigits = areNamed(decadePx, DIGIT_HEIGHT)
  return (
    <>
      <text class="unit" x={-6} y={-14} text-anchor="end">
        {unit}
      </text>
      {minorsOf([Math.floor(from + 1e-9), Math.ceil(to - 1e-9)], decadePx)
        .filter(({ value }) => Math.log10(value) >= from && Math.log10(value) <= to)
        .map(({ value, digit }) => {
          const y = (1 - place(UNITS[unit] * value, axes.pa)) * height
          return (
            <g key={`p${value}`}>
              <line class="grid minor" x1={0} x2={width} y1={y} y2={y} />
              {hasDigits && isNamed(digit) && (
                <text x={-6} y={y + 4} text-anchor="end">
                  {digit}
                </text>
              )}
            </g>
          )
        })}
      {decadesOf([Math.ceil(from - 1e-9), Math.floor(to + 1e-9)]).map((exponent) => {
        const y = (1 - place(UNITS[unit] * 10 ** exponent, axes.pa)) * height
        return (
          <g key={`p${exponent}`}>
            <line class="grid" x1={0} x2={width} y1={y} y2={y} />
            <text x={-6} y={y + 4} text-anchor="end">
              {decade(10 ** exponent)}
            </text>
          </g>
        )
      })}
    </>
  )
}
