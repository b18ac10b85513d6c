// Pressures as text, and the words that replace them.

import './pressure.css'
import type { JSX } from 'preact'
import type { Gauge, Quality, Reading } from '../api/types.ts'
import { parts, superscript } from '../lib/format.ts'
import { gas, QUALITIES } from '../lib/labels.ts'
import { qualityOf, type Sample } from '../lib/series.ts'
import { inUnit, type Unit } from '../lib/units.ts'

/** `1.23 × 10⁻⁶ mbar`. */
export function Pressure({ pa, unit }: { pa: number; unit: Unit }): JSX.Element {
  const { mantissa, exponent } = parts(inUnit(pa, unit))
  return (
    <span class="pressure">
      <span class="mantissa">{mantissa}</span>
      {exponent !== null && (
        <>
          <span class="times"> × </span>10<span class="power">{superscript(exponent)}</span>
        </>
      )}
      <span class="unit"> {unit}</span>
    </span>
  )
}

interface ReadingProps {
  pa: number | null
  quality: Quality
  unit: Unit
}

/** A valid pressure as a number, everything else as words. */
export function ReadingText({ pa, quality, unit }: ReadingProps): JSX.Element {
  if (quality === 'valid' && pa !== null) return <Pressure pa={pa} unit={unit} />
  return <span class={`no-pressure ${quality}`}>{QUALITIES[quality]}</span>
}

/** The end of the range, beside `over range` and `under range`. */
export function RangeLimit({ pa, quality, unit }: ReadingProps): JSX.Element | null {
  if (pa === null || (quality !== 'overrange' && quality !== 'underrange')) return null
  return (
    <span class="range-limit">
      {quality === 'overrange' ? 'above ' : 'below '}
      <Pressure pa={pa} unit={unit} />
    </span>
  )
}

/** The pressure corrected for the gas of the gauge, beside the indicated one. */
export function CorrectedPressure(props: { gauge: Gauge; reading: Reading; unit: Unit }): JSX.Element | null {
  const { gauge, reading, unit } = props
  if (gauge.gas.toLowerCase() === 'n2') return null
  if (reading.corrected_pa === null) {
    return <span class="corrected">no correction factor for {gas(gauge.gas)} in this range</span>
  }
  return (
    <span class="corrected">
      {gas(gauge.gas)}: <Pressure pa={reading.corrected_pa} unit={unit} />
    </span>
  )
}

/** A sample of a trend, in a data table. */
export function SampleText({ sample, unit }: { sample: Sample | null; unit: Unit }): JSX.Element {
  return <ReadingText pa={sample?.mean ?? null} quality={sample ? qualityOf(sample) : 'gap'} unit={unit} />
}
