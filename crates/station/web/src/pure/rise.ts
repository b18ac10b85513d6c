// What a rise of pressure says, in plain words.

import type { Rise } from '../api.ts'

/** The fitted pressure in Pa, so many seconds after the beginning. */
export function fitted(rise: Rise, seconds: number): number {
  const bend = rise.bend_pa !== null && rise.tau_s !== null ? rise.bend_pa * -Math.expm1(-seconds / rise.tau_s) : 0
  return rise.start_pa + rise.steady_pa_per_s * seconds + bend
}

/** Which part of the rise at its beginning is steady, 0 to 1. */
export function steadyPart(rise: Rise): number {
  const bending = rise.bend_pa !== null && rise.tau_s ? rise.bend_pa / rise.tau_s : 0
  const steady = Math.max(0, rise.steady_pa_per_s)
  return steady + bending > 0 ? steady / (steady + bending) : 0
}

/** Below this the curve is not what was fitted. free choice. */
const GOOD = 0.95

export function verdict(rise: Rise): { title: string; sentence: string } {
  if (rise.explained < GOOD) {
    return {
      title: 'The curve fits badly',
      sentence:
        'The pressure did something else than rise evenly or flatten out: a valve may have moved, or the marks stand wrong. ' +
        'Do not trust the numbers below.',
    }
  }
  if (rise.steady_pa_per_s <= 0 && rise.bend_pa === null) {
    return {
      title: 'No rise',
      sentence: 'The pressure does not rise: either the valve is open, or there is nothing to find.',
    }
  }
  if (rise.bend_pa === null) {
    return {
      title: 'A straight line: a leak',
      sentence:
        'The pressure rises by the same amount in every second, as air does through a leak (or gas through a seal). ' +
        'No outgassing can be told apart. A longer measurement may still show the line bend.',
    }
  }
  const percent = Math.round(steadyPart(rise) * 100)
  if (percent < 5) {
    return {
      title: 'The curve flattens: outgassing',
      sentence:
        `Nearly all of the gas comes from surfaces (the steady part is ${percent} % at the beginning). ` +
        'Pumping longer or baking helps; looking for a leak does not.',
    }
  }
  const mostly = percent >= 50 ? 'Mostly a leak, and some outgassing' : 'Mostly outgassing, and a leak'
  return {
    title: mostly,
    sentence:
      `At the beginning ${percent} % of the gas came in steadily, as through a leak, and ${100 - percent} % from surfaces. ` +
      'Outgassing fades, the leak stays.',
  }
}
