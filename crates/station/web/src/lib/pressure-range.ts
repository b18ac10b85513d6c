// The lowest and the highest pressure of many gauges.

import type { Gauge, Quality, Reading } from '../api/types.ts'
import { currentQuality } from './stale.ts'

/** A pressure, or the end of the range that it is beyond. */
export interface Extreme {
  pa: number
  quality: Quality
}

/**
 * The lowest and the highest of all readings; `null` if none is a pressure or the end of a range. The end below which a gauge cannot measure is
 * no highest pressure while another gauge has one.
 */
export function pressureRange(gauges: readonly Gauge[], sinceMs: number): { lowest: Extreme; highest: Extreme } | null {
  const all = gauges
    .flatMap((gauge) => gauge.readings.map((reading) => extremeOf(gauge, reading, sinceMs)))
    .filter((extreme) => extreme !== null)
    .sort((one, other) => one.pa - other.pa)
  const isMeasured = ({ quality }: Extreme): boolean => quality !== 'underrange'
  const [lowest, highest] = [all[0], all.filter(isMeasured).at(-1) ?? all.at(-1)]
  return lowest && highest ? { lowest, highest } : null
}

/** The pressure of a reading, or the end of the range that it is beyond; `null` if it is neither. */
export function extremeOf(gauge: Gauge, reading: Reading, sinceMs: number): Extreme | null {
  const quality = currentQuality(gauge, reading, sinceMs)
  const pa = reading.pa ?? reading.limit_pa
  const isPressure = quality === 'valid' || quality === 'underrange' || quality === 'overrange'
  return isPressure && pa !== null ? { pa, quality } : null
}
