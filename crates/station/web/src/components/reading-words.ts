// A reading in words, for pictures of the plant.

import { number } from '../lib/format.ts'
import type { PlacedReading } from '../lib/picture.ts'
import { inUnit, type Unit } from '../lib/units.ts'
import { t } from '../texts/texts.ts'
import { boundOf } from './pressure.tsx'

/** A reading as text: a pressure with its unit, `<` and `>` beyond the range, otherwise a word. */
export function readingWords({ reading, quality }: PlacedReading, unit: Unit): string {
  const pa = boundOf(reading)
  if (pa === null || !['valid', 'underrange', 'overrange'].includes(quality)) return t.qualities[quality]
  const sign = quality === 'underrange' ? '< ' : quality === 'overrange' ? '> ' : ''
  return `${sign}${number(inUnit(pa, unit))} ${unit}`
}
