// An identified plant: its numbers as text, and its chart on logarithmic axes.

import type { Bounds, Plant, TargetTime } from '../api/types.ts'
import { t } from '../texts/texts.ts'
import { age, number, ratio, unbroken } from './format.ts'
import { type Axes, place } from './pump-downs.ts'

/** `1.2 (1.0 to 1.5)` as its two parts, each number divided by a unit. */
export function boundsText(bounds: Bounds, unit: number): { value: string; interval: string } {
  return textsOf(bounds, (value) => unbroken(number(value / unit)))
}

/** The same for a number without a unit: `0.988 to 1.01`. */
export const ratioText = (bounds: Bounds): { value: string; interval: string } => textsOf(bounds, ratio)

function textsOf({ mean, low, high }: Bounds, text: (value: number) => string): { value: string; interval: string } {
  const upper = high === null || high === undefined ? t.identify.noLimit : text(high)
  const isBound = mean === 0 && high !== null && high !== undefined
  return { value: isBound ? `< ${text(high)}` : text(mean), interval: t.common.rangeText(text(low), upper) }
}

/** `2 h 5 min (1 h 50 min to 2 h 20 min)`. */
export function timesText({ mean, low, high }: TargetTime): string {
  const early = age(low * 1000)
  if (mean === null || mean === undefined) return t.identify.neverBefore(early)
  const late = high === null || high === undefined ? t.identify.never : age(high * 1000)
  return `${age(mean * 1000)} (${t.common.rangeText(early, late)})`
}

/** The title of a result and what it is worth. */
export function worth({ is_described, misfit }: Plant): { title: string; sentence: string } {
  return (is_described ? t.identify.described : t.identify.notDescribed)(ratio(misfit))
}

/** The first time that is drawn, in s: before it a logarithmic axis has decades without samples. */
export const EARLIEST = 0.1

/** Whole decades around measurement, fit and prediction; `null` without a point. */
export function axesOf({ residuals, prediction }: Plant): Axes | null {
  const times = [...residuals, ...prediction].map(({ s }) => s).filter((s) => s >= EARLIEST)
  const pressures = [...residuals.map(({ measured_pa }) => measured_pa), ...prediction.map(({ pa }) => pa.mean)]
  const positive = pressures.filter((pa) => pa > 0)
  if (times.length === 0 || positive.length === 0) return null
  const around = (numbers: number[]): [number, number] => {
    const from = Math.floor(Math.log10(Math.min(...numbers)))
    return [from, Math.max(from + 1, Math.ceil(Math.log10(Math.max(...numbers))))]
  }
  return { s: around(times), pa: around(positive) }
}

/** The points of a polyline in a box of this size; those outside the axes are moved to their edges. */
export function line(points: { s: number; pa: number }[], axes: Axes, width: number, height: number): string {
  const inside = (part: number): number => Math.min(1, Math.max(0, part))
  return points
    .filter(({ s, pa }) => s >= EARLIEST && pa > 0)
    .map(({ s, pa }) => {
      const [x, y] = [inside(place(s, axes.s)) * width, inside(1 - place(pa, axes.pa)) * height]
      return `${x.toFixed(1)},${y.toFixed(1)}`
    })
    .join(' ')
}
