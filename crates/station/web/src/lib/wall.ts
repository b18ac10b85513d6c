// The arrangement of the wall display: how many tiles fit, which page has which, and where an alarm stands.

import type { ActiveAlarms, Alarm } from '../api/types.ts'
import { t } from '../texts/texts.ts'
import { byUrgency, isActive } from './alarms.ts'
import { declaredNames } from './plant-states.ts'

/** The narrowest tile in pixels. chosen: its digits are 35 pixels high, readable from three metres on a usual screen. */
const NARROWEST = 340

/** The height of a tile as a part of its width: at least that of its texts, with two lines for an alarm. */
const HEIGHT = { least: 0.46, most: 0.6 }

/** Pages turn after this time. chosen: a page of twenty values is read in it. */
export const TURN_MS = 12_000

export interface Grid {
  columns: number
  rows: number
  /** The size of a tile in pixels. */
  width: number
  height: number
}

/** The grid with the largest tiles that shows `count` of them; if the narrowest do not fit, the grid of the narrowest. */
export function gridOf(count: number, width: number, height: number): Grid {
  const most = Math.max(1, Math.floor(width / NARROWEST))
  const grid = (columns: number): Grid => {
    const tile = Math.max(1, Math.floor(width / columns))
    const rows = Math.max(1, Math.floor(height / (tile * HEIGHT.least)))
    return { columns, rows, width: tile, height: Math.floor(Math.min(tile * HEIGHT.most, height / rows)) }
  }
  for (let columns = 1; columns < most; columns += 1) {
    const found = grid(columns)
    // A tile that is higher than the screen is no larger tile.
    if (found.width * HEIGHT.least <= height && found.columns * found.rows >= count) return found
  }
  return grid(most)
}

/** How many of the problems stay on every page. */
export const stayingOf = (problems: number, perPage: number): number => Math.min(problems, Math.floor(perPage / 2))

/** The pages: problems that fill at most half of a page stay on every page, all other tiles turn. */
export function pagesOf<T>(problems: readonly T[], others: readonly T[], perPage: number): T[][] {
  if (problems.length + others.length <= perPage) return [[...problems, ...others]]
  const staying = problems.slice(0, stayingOf(problems.length, perPage))
  const turning = [...problems.slice(staying.length), ...others]
  const size = perPage - staying.length
  const pages: T[][] = []
  for (let first = 0; first < turning.length; first += size) {
    pages.push([...staying, ...turning.slice(first, first + size)])
  }
  return pages
}

/** More pages than these take longer than a minute. */
const MOST_PAGES = 5

/**
 * Whether the gauges of a segment share a tile: a tile for each reading would make too many pages. It depends on the plant and the
 * window alone. With the room beside the lines about problems, or with the number of problems, the arrangement would change with
 * every alarm, and again with the line that this adds.
 */
export function isShared(readings: number, width: number, height: number): boolean {
  const { columns, rows } = gridOf(readings, width, height)
  return readings > MOST_PAGES * columns * rows
}

/** The gauges of a segment of which none has a problem. */
export interface QuietSegment<G> {
  segment: string
  gauges: G[]
}

/** One tile for the gauges of each segment that have no problem; the quiet channels of a controller with one keep their tiles. */
export function sharedTiles<T extends { gauge: { segment: string } }>(
  problems: readonly T[],
  quiet: readonly T[],
  segments: readonly string[],
): (T | QuietSegment<T['gauge']>)[] {
  const troubled = new Set<T['gauge']>(problems.map(({ gauge }) => gauge))
  const gauges = [...new Set<T['gauge']>(quiet.map(({ gauge }) => gauge))].filter((gauge) => !troubled.has(gauge))
  const shared = segments.map((segment) => ({ segment, gauges: gauges.filter((gauge) => gauge.segment === segment) }))
  return [...quiet.filter(({ gauge }) => troubled.has(gauge)), ...shared.filter(({ gauges }) => gauges.length > 0)]
}

/** The number of the page at a time, from 0. */
export const pageAt = (now: number, pages: number): number => Math.floor(now / TURN_MS) % Math.max(1, pages)

/** What stands on a tile. */
export interface Tile<R> {
  /** `null` for a whole gauge. */
  reading: R | null
  /** The active alarms that the tile shows. */
  alarms: Alarm[]
}

/**
 * The tiles of a gauge, one for each reading, with its active alarms. An alarm about a reading stands on the tile of the reading; an
 * alarm about a whole gauge with several readings has a tile of its own, as nothing says which of them it concerns. So has a fault of the
 * gauge, `hasFault`.
 */
export function tilesOf<R extends { series: string }>(
  readings: readonly R[],
  alarms: Alarm[],
  hasFault: boolean,
): Tile<R>[] {
  const active = alarms.filter(isActive)
  const isWhole = ({ series }: Alarm): boolean => !readings.some((reading) => reading.series === series)
  const [only, ...more] = readings
  if (!only) return [{ reading: null, alarms: active }]
  if (more.length === 0) return [{ reading: only, alarms: active }]
  const whole = active.filter(isWhole)
  const tiles = readings.map((reading) => ({
    reading,
    alarms: active.filter(({ series }) => series === reading.series),
  }))
  return whole.length > 0 || hasFault ? [{ reading: null, alarms: whole }, ...tiles] : tiles
}

/** A page has this many lines for alarms. chosen: on a phone they leave two thirds for the tiles of the display. */
const MOST_LINES = 3

/** Whether the alarm is of none of these gauges: of a segment, of the station. */
export const hasNoGauge = ({ gauge }: Alarm, gauges: readonly { name: string }[]): boolean =>
  !gauges.some(({ name }) => name === gauge)

/** The active ones of these alarms, the most urgent first; and how many have no line. */
export function alarmLines(alarms: Alarm[]): { lines: Alarm[]; more: number } {
  const active = alarms.filter(isActive).sort(byUrgency)
  return { lines: active.slice(0, MOST_LINES), more: Math.max(0, active.length - MOST_LINES) }
}

type Silent = Pick<ActiveAlarms, 'plant_states' | 'suppressed' | 'shelved' | 'out_of_service'>

/** `Plant state: Vented · 4 suppressed, 1 shelved`: without it a display without active alarms would say that all is well. */
export function silentText({ plant_states, suppressed, shelved, out_of_service }: Silent): string {
  const counts = [
    suppressed > 0 && t.wall.suppressed(suppressed),
    shelved > 0 && t.wall.shelved(shelved),
    out_of_service > 0 && t.wall.outOfService(out_of_service),
  ]
  const states = plant_states.length > 0 && t.plantStates.prefix + declaredNames(plant_states)
  return [states, counts.filter(Boolean).join(', ')].filter(Boolean).join(' · ')
}
