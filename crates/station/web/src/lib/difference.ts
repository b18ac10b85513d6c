// Two samples of a series compared: how much, how many times, how fast.

import { t } from '../texts/texts.ts'
import { number, ratio as shortNumber } from './format.ts'
import { OVER, type Sample, UNDER } from './series.ts'
import { inUnit, type Unit } from './units.ts'

/** A later sample compared with the reference. */
export interface Difference {
  /** The later pressure over that of the reference. */
  ratio: number
  /** In Pa. */
  difference: number
  /** The time between both in milliseconds, less than 0 if the sample is the earlier one. */
  ms: number
}

/** `null` unless both samples have a pressure within the range of the gauge: the end of a range is no measured pressure. */
export function differenceOf(reference: Sample | null, sample: Sample | null, ms: number): Difference | null {
  const [first, second] = [measured(reference), measured(sample)]
  return first === null || second === null ? null : { ratio: second / first, difference: second - first, ms }
}

function measured(sample: Sample | null): number | null {
  if (sample === null || sample.bits & (OVER | UNDER)) return null
  return sample.mean !== null && sample.mean > 0 ? sample.mean : null
}

/** The units of time of a slope, and up to which time between the samples each is used. */
const SLOPE_UNITS = [
  { name: 's', ms: 1_000, most: 120_000 },
  { name: 'min', ms: 60_000, most: 2 * 3_600_000 },
  { name: 'h', ms: 3_600_000, most: 2 * 86_400_000 },
]
const DAY = { name: 'd', ms: 86_400_000 }

/** A ratio as a plain number where that is short. */
function ratioText(ratio: number): string {
  return ratio >= 0.01 && ratio < 10_000 ? String(Number(ratio.toPrecision(3))) : number(ratio)
}

/** A part of a difference: its number, and what it is, with its unit. */
export interface DifferencePart {
  value: string
  unit: string
  heading: string
}

/** Ratio, difference and the mean slopes, in decades and in pressure. All curves have the same units, which depend on the time alone. */
export function differenceParts({ ratio, difference, ms }: Difference, unit: Unit): DifferencePart[] {
  const size = inUnit(difference, unit)
  const parts = [
    { value: `× ${ratioText(ratio)}`, unit: '', heading: t.trends.ratio },
    { value: signed(size, number), unit, heading: t.trends.difference },
  ]
  if (ms === 0) return parts
  const per = SLOPE_UNITS.find(({ most }) => Math.abs(ms) <= most) ?? DAY
  const times = ms / per.ms
  return [
    ...parts,
    {
      value: signed(Math.log10(ratio) / times, shortNumber),
      unit: `${t.common.decades}/${per.name}`,
      heading: t.trends.slope,
    },
    { value: signed(size / times, number), unit: `${unit}/${per.name}`, heading: t.trends.slope },
  ]
}

/** `× 0.25, −3.75 × 10⁻⁷ mbar, −0.6 decades/min, −3.75 × 10⁻⁷ mbar/min`. */
export function differenceText(difference: Difference, unit: Unit): string {
  return differenceParts(difference, unit)
    .map(({ value, unit }) => `${value} ${unit}`.trim())
    .join(', ')
}

/** A number with its sign in front; zero has none. */
export function signed(value: number, text: (size: number) => string): string {
  return (value < 0 ? '−' : value > 0 ? '+' : '') + text(Math.abs(value))
}
