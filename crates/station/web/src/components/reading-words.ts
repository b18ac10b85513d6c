// A reading in words, for pictures of the plant.

import { number } from '../lib/format.ts'
import { type PlacedReading, shownPressure } from '../lib/picture.ts'
import { inUnit, type Unit } from '../lib/units.ts'
import { t } from '../texts/texts.ts'

/** A reading as text: a pressure with its unit, `<` and `>` beyond the range, otherwise a word. */
export function readingWords(placed: PlacedReading, unit: Unit): string {
  const { quality } = placed
  const pa = shownPressure(placed)
  if (pa === null) return t.qualities[quality]
  const sign = quality === 'underrange' ? '< ' : quality === 'overrange' ? '> ' : ''
  return `${sign}${number(inUnit(pa, unit))} ${unit}`
}
