// A pressure to be read: its number, its unit, and in its place words where there is none.

import type { JSX } from 'preact'
import type { Quality } from '../api.ts'
import { parts, superscript } from '../pure/format.ts'
import { inUnit, type Unit } from '../pure/units.ts'
import { QUALITIES } from '../pure/words.ts'

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

/** What a gauge shows: a pressure, or the end of its range with a mark, or a word. Never a number that means something else. */
export function Shown({ pa, quality, unit }: { pa: number | null; quality: Quality; unit: Unit }): JSX.Element {
  if (quality === 'valid' && pa !== null) return <Pressure pa={pa} unit={unit} />
  return <span class={`no-pressure ${quality}`}>{QUALITIES[quality]}</span>
}

/** Beside an overrange or underrange: where the range ends. */
export function Limit({ pa, quality, unit }: { pa: number | null; quality: Quality; unit: Unit }): JSX.Element | null {
  if (pa === null || (quality !== 'overrange' && quality !== 'underrange')) return null
  return (
    <span class="limit">
      {quality === 'overrange' ? 'above ' : 'below '}
      <Pressure pa={pa} unit={unit} />
    </span>
  )
}
