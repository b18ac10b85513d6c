// A rate-of-rise fit: its curve and its meaning.

import type { Rise } from '../api/types.ts'

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

const MEANING: Record<Rise['cause'], { title: string; sentence: string }> = {
  leak: {
    title: 'A leak',
    sentence: 'Air through a leak, or gas through a seal, is certain. Outgassing is not certain.',
  },
  outgassing: {
    title: 'Outgassing',
    sentence: 'Outgassing of surfaces is certain. A leak is not certain: its interval has the largest leak possible.',
  },
  both: {
    title: 'A leak and outgassing',
    sentence: 'Both are certain. Outgassing decreases with time; a leak does not.',
  },
  undistinguished: {
    title: 'Leak and outgassing cannot be distinguished',
    sentence:
      'Each of them explains this rise alone. A longer measurement, or one after longer pumping, separates them.',
  },
  'no-rise': {
    title: 'No rise',
    sentence: 'The pressure does not rise: the valve is open, or there is neither a leak nor outgassing.',
  },
}

export function verdict(rise: Rise): { title: string; sentence: string } {
  if (rise.misfit <= MISFIT || rise.cause === 'no-rise') return MEANING[rise.cause]
  return {
    title: 'The fit does not match the curve',
    sentence:
      'The rise is neither that of a leak nor that of outgassing: a valve may have moved, or start and end may be set wrongly. ' +
      'Do not rely on the numbers below.',
  }
}
