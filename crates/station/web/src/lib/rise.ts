// A rate-of-rise fit: its curve and its meaning.

import type { Rise } from '../api/types.ts'

/** The fitted pressure in Pa, `seconds` after the start. */
export function fitted(rise: Rise, seconds: number): number {
  const bend = rise.bend_pa !== null && rise.tau_s !== null ? rise.bend_pa * -Math.expm1(-seconds / rise.tau_s) : 0
  return rise.start_pa + rise.steady_pa_per_s * seconds + bend
}

/** The steady part of the rate at the start, 0 to 1. */
export function steadyPart(rise: Rise): number {
  const bending = rise.bend_pa !== null && rise.tau_s ? rise.bend_pa / rise.tau_s : 0
  const steady = Math.max(0, rise.steady_pa_per_s)
  return steady + bending > 0 ? steady / (steady + bending) : 0
}

/** Below this the fit does not describe the curve. Free choice. */
const GOOD = 0.95

export function verdict(rise: Rise): { title: string; sentence: string } {
  if (rise.explained < GOOD) {
    return {
      title: 'The fit does not match the curve',
      sentence:
        'The pressure neither rose evenly nor flattened out: a valve may have moved, or start and end may be set wrongly. ' +
        'Do not rely on the numbers below.',
    }
  }
  if (rise.steady_pa_per_s <= 0 && rise.bend_pa === null) {
    return {
      title: 'No rise',
      sentence: 'The pressure does not rise: the valve is open, or there is neither a leak nor outgassing.',
    }
  }
  if (rise.bend_pa === null) {
    return {
      title: 'A straight line: a leak',
      sentence:
        'The pressure rises by the same amount in every second, as it does with air through a leak or gas through a seal. ' +
        'No outgassing is visible. A longer measurement may still show the curve flatten.',
    }
  }
  const percent = Math.round(steadyPart(rise) * 100)
  if (percent < 5) {
    return {
      title: 'The curve flattens: outgassing',
      sentence:
        `Nearly all of the gas comes from surfaces (the steady part is ${percent} % at the start). ` +
        'Pump longer or bake; a leak search will not help.',
    }
  }
  const mostly = percent >= 50 ? 'Mostly a leak, with some outgassing' : 'Mostly outgassing, with a leak'
  return {
    title: mostly,
    sentence:
      `At the start ${percent} % of the gas came in steadily, as through a leak, and ${100 - percent} % from surfaces. ` +
      'Outgassing decreases with time; a leak does not.',
  }
}
