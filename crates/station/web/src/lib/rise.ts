// A rate-of-rise fit: its curve and its meaning.

import type { Rise } from '../api/types.ts'
import { t } from '../texts/texts.ts'
import type { Value } from './series.ts'

/** The fitted pressure in Pa, `seconds` after the start; `null` before the first and after the last fitted point. */
export function fitted(rise: Rise, seconds: number): number | null {
  const next = rise.fitted.findIndex(({ s }) => s >= seconds)
  const after = rise.fitted[next]
  if (after === undefined) return null
  if (after.s === seconds) return after.pa
  const before = rise.fitted[next - 1]
  if (before === undefined) return null
  return before.pa + ((after.pa - before.pa) * (seconds - before.s)) / (after.s - before.s)
}

/**
 * The time from which the pressures set the scale of a rise: that of a measurement, otherwise that of the lowest pressure. The fall before it
 * may be a billion times higher than the rise.
 */
export function scaleFrom(times: number[], means: Value[], [from, to]: [number, number], begin: number | null): number {
  if (begin !== null) return Math.max(from, begin)
  let lowest = { at: from, pressure: Infinity }
  times.forEach((at, index) => {
    const pressure = means[index]
    if (at >= from && at <= to && typeof pressure === 'number' && pressure < lowest.pressure) lowest = { at, pressure }
  })
  // While the pressure falls, the last part of the window has a scale too.
  return Math.max(from, Math.min(lowest.at, to - (to - from) * LEAST_PART))
}

/** The least part of the window that sets the scale. Free choice. */
const LEAST_PART = 0.1

/** Above this the fit does not describe the curve: residuals of three times the noise. Free choice. */
const MISFIT = 3

export function verdict(rise: Rise): { title: string; sentence: string } {
  if (rise.misfit <= MISFIT || rise.cause === 'no-rise') return t.rise.causes[rise.cause]
  return t.rise.misfit
}
