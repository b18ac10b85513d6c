// A rate-of-rise fit: its curve and its meaning.

import type { Rise } from '../api/types.ts'
import { t } from '../texts/texts.ts'

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

/** Above this the fit does not describe the curve: residuals of three times the noise. Free choice. */
const MISFIT = 3

export function verdict(rise: Rise): { title: string; sentence: string } {
  if (rise.misfit <= MISFIT || rise.cause === 'no-rise') return t.rise.causes[rise.cause]
  return t.rise.misfit
}
