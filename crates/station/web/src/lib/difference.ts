// Two samples of a series compared: how much, how many times, how fast.

import { t } from '../texts/texts.ts'
import { number } from './format.ts'
import { OVER, type Sample, UNDER } from './series.ts'
import { inUnit, type Unit } from './units.ts'

/** A later sample compared with the reference. */
export interface Difference {
  /** The later pressure over that of the reference. */
  ratio: number
  /** In Pa. */
  difference: number
  /** The mean slope between both, in decades per millisecond; `null` if there is no time between them. */
  slope: number | null
}

/** `null` unless both samples have a pressure within the range of the gauge: the end of a range is no measured pressure. */
export function differenceOf(reference: Sample | null, sample: Sample | null, ms: number): Difference | null {
  const [first, second] = [measured(reference), measured(sample)]
  if (first === null || second === null) return null
  const ratio = second / first
  return { ratio, difference: second - first, slope: ms === 0 ? null : Math.log10(ratio) / ms }
}

function measured(sample: Sample | null): number | null {
  if (sample === null || sample.bits & (OVER | UNDER)) return null
  return sample.mean !== null && sample.mean > 0 ? sample.mean : null
}

/** The units of a slope, the shortest first. */
const SLOPE_UNITS = [
  { name: 's', ms: 1_000 },
  { name: 'min', ms: 60_000 },
  { name: 'h', ms: 3_600_000 },
]
const DAY = { name: 'd', ms: 86_400_000 }

/** A ratio as a plain number where that is short. */
function ratioText(ratio: number): string {
  return ratio >= 0.01 && ratio < 10_000 ? String(Number(ratio.toPrecision(3))) : number(ratio)
}

/** `× 0.25, −3.75 × 10⁻⁷ mbar, −0.6 decades/min`. */
export function differenceText({ ratio, difference, slope }: Difference, unit: Unit): string {
  const size = `${signed(inUnit(difference, unit), number)} ${unit}`
  return [`× ${ratioText(ratio)}`, size, ...(slope === null ? [] : [slopeText(slope)])].join(', ')
}

/** `−0.31 decades/min`: in the first unit in which the slope is at least a tenth of a decade, otherwise in days. */
export function slopeText(decadesPerMs: number): string {
  const { name, ms } = SLOPE_UNITS.find(({ ms }) => Math.abs(decadesPerMs * ms) >= 0.1) ?? DAY
  return `${signed(Number((decadesPerMs * ms).toPrecision(2)), String)} ${t.common.decades}/${name}`
}

/** A number with its sign in front; zero has none. */
export function signed(value: number, text: (size: number) => string): string {
  return (value < 0 ? '−' : value > 0 ? '+' : '') + text(Math.abs(value))
}
