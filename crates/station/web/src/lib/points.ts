// The value of a point in words.

import type { Gauge, Point } from '../api/types.ts'

/** The value with its unit, or why the number is bad; `null` without a value, and for one that is too old. */
export function pointText({ text, quality }: Point, isStale: boolean): string | null {
  return isStale || quality === 'stale' ? null : text
}

/** Why a point has no value, if the station knows it: its record was not read. */
export function pointCause({ text, quality }: Point): string | null {
  return quality === 'stale' && text !== '' ? text : null
}

/** What the wall shows of a slave: that it reports a fault, or its first point, which is the most important one of the station's file, with its name. */
export function slaveValue(
  { state, parameters }: Pick<Gauge, 'state' | 'parameters'>,
  isStale: boolean,
): { point: string; text: string | null; isFault: boolean } {
  const [first] = parameters
  const text = first ? pointText(first, isStale) : null
  const isFault = state === 'fault' && !isStale
  return { point: first && text !== null && !isFault ? first.target : '', text, isFault }
}
