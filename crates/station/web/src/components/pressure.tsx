// Pressures as text, and the words that replace them.

import './pressure.css'
import type { JSX } from 'preact'
import type { Gauge, Quality, Reading } from '../api/types.ts'
import { parts, superscript } from '../lib/format.ts'
import { gas } from '../lib/labels.ts'
import { qualityOf, type Sample } from '../lib/series.ts'
import { inUnit, type Unit } from '../lib/units.ts'
import { t } from '../texts/texts.ts'

/** `1.23 × 10⁻⁶ mbar`. */
export function Pressure({ pa, unit }: { pa: number; unit: Unit }): JSX.Element {
  const { mantissa, exponent } = parts(inUnit(pa, unit))
  return (
    <span class="pressure">
      <span class={exponent === null ? 'mantissa plain' : 'mantissa'}>{mantissa}</span>
      {exponent !== null && (
        <>
          <span class="times"> × </span>10
          <span class="power" data-room={roomOf(exponent)}>
            {superscript(exponent)}
          </span>
        </>
      )}
      <span class="unit"> {unit}</span>
    </span>
  )
}

/** The signs that a power lacks to be as wide as the widest one, `⁻¹⁰`: superscript digits are equally wide. */
const roomOf = (exponent: number): string => (exponent < 0 ? '' : '⁻') + (Math.abs(exponent) < 10 ? '⁰' : '')

interface ReadingProps {
  /** The pressure, or the end of the range that it is beyond. */
  pa: number | null
  quality: Quality
  unit: Unit
}

const SIGNS: Partial<Record<Quality, string>> = { valid: '', overrange: '> ', underrange: '< ' }

/** A valid pressure as a number, one beyond the range as `<` or `>` with the end of the range, everything else as words. */
export function ReadingText({ pa, quality, unit }: ReadingProps): JSX.Element {
  const sign = SIGNS[quality]
  if (pa === null || sign === undefined) return <span class={`no-pressure ${quality}`}>{t.qualities[quality]}</span>
  if (sign === '') return <Pressure pa={pa} unit={unit} />
  return (
    <span class={`no-pressure ${quality}`} title={t.qualities[quality]}>
      {sign}
      <Pressure pa={pa} unit={unit} />
    </span>
  )
}

/** The pressure of a reading, or the end of the range that it is beyond. */
export const boundOf = ({ pa, limit_pa }: Reading): number | null => pa ?? limit_pa

/** Channel, sensor and quality of a reading, beside its pressure. */
export function ReadingDetails(props: { gauge: Gauge; reading: Reading; quality: Quality; unit: Unit }): JSX.Element {
  const { gauge, reading, quality, unit } = props
  const channel = gauge.readings.length > 1 ? t.reading.channel(reading.instance) : ''
  const sensor = reading.principle ? t.principles[reading.principle] : ''
  const beyond = quality === 'overrange' || quality === 'underrange' ? t.qualities[quality] : ''
  const words = [sensor, beyond].filter(Boolean).join(' · ')
  return (
    <p class="reading-details">
      {channel && <span class="reading-channel">{channel}</span>}
      {words && <span class="sensor">{words}</span>}
      {reading.cause && quality !== 'stale' && <span class="cause">{reading.cause}</span>}
      {quality === 'valid' && <CorrectedPressure gauge={gauge} reading={reading} unit={unit} />}
    </p>
  )
}

/** The pressure corrected for the gas of the gauge, beside the indicated one. */
export function CorrectedPressure(props: { gauge: Gauge; reading: Reading; unit: Unit }): JSX.Element | null {
  const { gauge, reading, unit } = props
  if (gauge.gas.toLowerCase() === 'n2') return null
  if (reading.corrected_pa === null) {
    return <span class="corrected">{t.reading.noFactor(gas(gauge.gas))}</span>
  }
  return (
    <span class="corrected">
      {gas(gauge.gas)}: <Pressure pa={reading.corrected_pa} unit={unit} />
    </span>
  )
}

/** A sample of a trend, in a data table. */
export function SampleText({ sample, unit }: { sample: Sample | null; unit: Unit }): JSX.Element {
  return <ReadingText pa={sample?.mean ?? null} quality={sample ? qualityOf(sample) : 'stale'} unit={unit} />
}
