// Pump-downs over each other: their curves on logarithmic axes, and their times as text.

import type { PumpDown, PumpDownLevel } from '../api/types.ts'
import { t } from '../texts/texts.ts'
import { age } from './format.ts'

export interface Axes {
  /** Whole decades of seconds and of Pa. */
  s: [number, number]
  pa: [number, number]
}

/** Whole decades around all curves; `null` without a point. */
export function axesOf(runs: PumpDown[]): Axes | null {
  const points = runs.flatMap(({ curve }) => curve).filter(({ s, pa }) => s > 0 && pa > 0)
  if (points.length === 0) return null
  const around = (numbers: number[]): [number, number] => [
    Math.floor(Math.log10(Math.min(...numbers))),
    Math.ceil(Math.log10(Math.max(...numbers))),
  ]
  const wide = ([from, to]: [number, number]): [number, number] => [from, Math.max(to, from + 1)]
  return { s: wide(around(points.map(({ s }) => s))), pa: wide(around(points.map(({ pa }) => pa))) }
}

/** The whole numbers from one to another. */
export const decadesOf = ([from, to]: [number, number]): number[] =>
  Array.from({ length: to - from + 1 }, (_, step) => from + step)

/** The position of a number on a logarithmic axis, 0 to 1. */
export const place = (value: number, [from, to]: [number, number]): number => (Math.log10(value) - from) / (to - from)

/** The points of a polyline in a box of this size. */
export function polyline(run: PumpDown, axes: Axes, width: number, height: number): string {
  return run.curve
    .filter(({ s, pa }) => s > 0 && pa > 0)
    .map(({ s, pa }) => `${(place(s, axes.s) * width).toFixed(1)},${((1 - place(pa, axes.pa)) * height).toFixed(1)}`)
    .join(' ')
}

/** What the list says of a run without a deviation: a run that was compared with no other one is not as usual. */
export const usualness = ({ levels }: Pick<PumpDown, 'levels'>): string =>
  levels.some(({ usual }) => usual) ? t.pumpDowns.notDeviating : t.pumpDowns.notCompared

const seconds = (s: number): string => age(s * 1000)

/** `1 h 20 min`, or why there is none. */
export const timeText = ({ s }: PumpDownLevel): string =>
  s === null || s === undefined ? t.pumpDowns.notReached : seconds(s)

/** `1 h 0 min (54 min 3 s to 1 h 6 min, 10 pump-downs)`. */
export function usualText({ usual }: PumpDownLevel): string {
  if (!usual) return '–'
  return t.pumpDowns.usualText(seconds(usual.s), seconds(usual.least_s), seconds(usual.most_s), usual.runs)
}
