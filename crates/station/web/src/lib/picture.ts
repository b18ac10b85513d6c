// The picture of the plant: which reading leads a volume, what is between the volumes, and the scale of its shades.

import type {
  Alarm,
  Gauge,
  PlantPart,
  PlantPartStatus,
  PlantPicture,
  PlantVolume,
  Quality,
  Reading,
} from '../api/types.ts'
import { t } from '../texts/texts.ts'
import { activeCounts, countsText, isActive } from './alarms.ts'
import type { Layout } from './plant-layout.ts'

/** A reading of a volume, with its gauge and its present quality. */
export interface PlacedReading {
  gauge: Gauge
  reading: Reading
  quality: Quality
}

/** The gauges of a volume: its readings in the order of the station's file, and the names that have no reading. */
export interface VolumeState {
  readings: PlacedReading[]
  /** The reading that the picture shows: the first valid one, otherwise the first one beyond its range, otherwise the first one. */
  leading: PlacedReading | null
  silent: string[]
  alarms: Alarm[]
}

/** The readings that a name stands for: a series alone, or a gauge without the series that other volumes name. */
function readingsNamed(name: string, gauges: Gauge[], named: Set<string>): { gauge: Gauge; reading: Reading }[] {
  const whole = gauges.find((gauge) => gauge.name === name)
  if (whole) {
    return whole.readings
      .filter(({ series }) => series === name || !named.has(series))
      .map((reading) => ({ gauge: whole, reading }))
  }
  return gauges.flatMap((gauge) =>
    gauge.readings.filter(({ series }) => series === name).map((reading) => ({ gauge, reading })),
  )
}

/** All names that volumes give to gauges and channels. */
export const namesIn = (plant: PlantPicture): Set<string> => new Set(plant.volumes.flatMap(({ gauges }) => gauges))

export function volumeState(
  volume: PlantVolume,
  named: Set<string>,
  gauges: Gauge[],
  alarms: Alarm[],
  qualityOf: (gauge: Gauge, reading: Reading) => Quality,
): VolumeState {
  const placed = volume.gauges.map((name) => ({ name, found: readingsNamed(name, gauges, named) }))
  const readings = placed.flatMap(({ found }) =>
    found.map(({ gauge, reading }) => ({ gauge, reading, quality: qualityOf(gauge, reading) })),
  )
  const leading = readings.find(({ quality }) => quality === 'valid') ?? readings.find(isBound) ?? readings[0] ?? null
  const series = new Set(readings.map(({ reading }) => reading.series))
  return {
    readings,
    leading,
    silent: placed.filter(({ found }) => found.length === 0).map(({ name }) => name),
    alarms: alarms.filter((alarm) => isActive(alarm) && isIn(alarm, volume, series)),
  }
}

/** Whether an alarm is in a volume with these series: one of a channel is where the channel is, any other one of a gauge where the gauge is named. */
const isIn = (alarm: Alarm, volume: PlantVolume, series: Set<string>): boolean =>
  alarm.series && alarm.series !== alarm.gauge ? series.has(alarm.series) : volume.gauges.includes(alarm.gauge ?? '')

/** Tells of an alarm in which volume it is. One about several gauges is in a volume if all of them are. */
export function volumesOfAlarms(plant: PlantPicture, gauges: Gauge[]): (alarm: Alarm) => string | null {
  const named = namesIn(plant)
  const volumes = plant.volumes.map((volume) => {
    const readings = volume.gauges.flatMap((name) => readingsNamed(name, gauges, named))
    return { volume, series: new Set(readings.map(({ reading }) => reading.series)) }
  })
  const hasAll = (several: Alarm['several'], series: Set<string>): boolean =>
    several?.series.every((name) => series.has(name)) ?? false
  return (alarm) =>
    volumes.find(({ volume, series }) => hasAll(alarm.several, series) || isIn(alarm, volume, series))?.volume.name ??
    null
}

/** Whether a reading is the end of the range that the pressure is beyond, and not the pressure. */
export const isBound = ({ quality }: PlacedReading): boolean => quality === 'underrange' || quality === 'overrange'

/** The pressure of a reading, or the end of the range that it is beyond; `null` if it is a word. */
export function shownPressure(placed: PlacedReading): number | null {
  const { quality, reading } = placed
  return quality === 'valid' || isBound(placed) ? (reading.pa ?? reading.limit_pa) : null
}

/** The series that a volume shows, how many readings it has, and how many of them are a word instead of a pressure. */
export function countsOf({ leading, readings, silent }: VolumeState): { shown: string; all: number; without: number } {
  return {
    shown: leading?.reading.series ?? silent[0] ?? '',
    all: readings.length + silent.length,
    without: readings.filter((placed) => shownPressure(placed) === null).length + silent.length,
  }
}

/** `alarms: 1 high, 3 medium`; empty without an active one. */
export function alarmsText(alarms: Alarm[]): string {
  const counts = activeCounts(alarms)
  return counts.length > 0 ? t.alarms.counted(countsText(counts)) : ''
}

/** The decades of the shades, as powers of ten in Pa: from ultra-high vacuum to the atmosphere. */
export const SHADES: [number, number] = [-8, 5]

/** How dark a pressure is drawn, 0 to 1 over the decades of the shades. */
export function shade(pa: number | null): number | null {
  if (pa === null || !(pa > 0)) return null
  const part = (Math.log10(pa) - SHADES[0]) / (SHADES[1] - SHADES[0])
  return Math.min(1, Math.max(0, part))
}

/** The zones in the order of the station's file. */
export const zonesOf = ({ volumes }: PlantPicture): string[] => [
  ...new Set(volumes.flatMap(({ zone }) => (zone === null ? [] : [zone]))),
]

/** The state of a part in a word or two: `open`, `runs 98 %`. A tube has no state. */
export function stateWords({ kind }: PlantPart, status: PlantPartStatus | undefined): string {
  if (kind === 'tube') return ''
  if (!status) return t.plant.notReported
  const { state, detail } = status
  switch (state) {
    case 'open':
      return kind === 'leak' ? t.plant.leaks : t.plant.open
    case 'closed':
      return kind === 'leak' ? t.plant.tight : t.plant.closed
    case 'running':
      return detail ? t.plant.runsAt(detail) : t.plant.runs
    case 'stopped':
      return t.plant.stands
  }
}

/** Whether gas passes a part: a closed one is drawn with thin lines. `null` if nothing reports it. */
export function passes({ kind }: PlantPart, status: PlantPartStatus | undefined): boolean | null {
  if (kind === 'tube') return true
  return status ? status.state === 'open' || status.state === 'running' : null
}

/** A leak that does not leak is nothing that a user has to see. */
export const isHidden = (part: PlantPart, status: PlantPartStatus | undefined): boolean =>
  part.kind === 'leak' && passes(part, status) === false

/** The room above the highest box of a picture. */
const ABOVE = 8

/** Where a picture begins that goes from top to bottom: without room for the parts that are hidden above all others. */
export function topOf({ direction, boxes, zones }: Layout, hidden: PlantPart[]): number {
  // From left to right the same would change the width, and with it the scale of the picture.
  if (direction === 'LR') return 0
  const ids = new Set(hidden.map(({ name }) => partNode(name)))
  const shown = [...zones.map(({ box }) => box), ...[...boxes].filter(([id]) => !ids.has(id)).map(([, box]) => box)]
  return Math.max(0, Math.min(...shown.map(({ y, height }) => y - height / 2)) - ABOVE)
}

/** A line of the picture, in the direction of the layout: from the outside over the volumes to the pumps. */
export interface Line {
  part: string
  from: string
  to: string
}

export const volumeNode = (name: string): string => `volume ${name}`
export const partNode = (name: string): string => `part ${name}`

/** The lines of a part: two for one between two volumes, otherwise one. */
export function linesOf({ name, kind, volumes: [first, second] }: PlantPart): Line[] {
  if (first === undefined) return []
  const part = partNode(name)
  const outside = kind === 'leak' || kind === 'vent' || kind === 'inlet'
  const one = outside
    ? { part: name, from: part, to: volumeNode(first) }
    : { part: name, from: volumeNode(first), to: part }
  return second === undefined ? [one] : [one, { part: name, from: part, to: volumeNode(second) }]
}

/** Whether the author of a drawing says that it is made for both themes. Editors draw on white. */
export const isForBothThemes = (drawing: string): boolean =>
  /^<svg\b[^>]*\sstyle="[^"]*\bcolor-scheme\s*:[^;"]*\bdark\b/.test(drawing)
