// Conditions, symbols and order of alarms.

import type { ActiveAlarms, Alarm, AlarmEvent, Priority } from '../api/types.ts'
import { t } from '../texts/texts.ts'
import { number, unbroken } from './format.ts'
import { inUnit, type Unit } from './units.ts'

export const PRIORITIES: Priority[] = ['high', 'medium', 'low']

/** A number for each priority, in a shape of its own: it can be told without colours, and it is no direction of a pressure. */
export const NUMBERS: Record<Priority, string> = { high: '1', medium: '2', low: '3' }

/** Whether the condition of the alarm holds. */
export const isActive = ({ state }: Pick<Alarm, 'state'>): boolean =>
  state === 'unacknowledged' || state === 'acknowledged'
export const isUnacknowledged = ({ state }: Alarm): boolean => state === 'unacknowledged' || state === 'returned'

/** Active alarms first, then by priority, then unacknowledged alarms, then the latest. */
export function byUrgency(one: Alarm, other: Alarm): number {
  return (
    Number(isActive(other)) - Number(isActive(one)) ||
    PRIORITIES.indexOf(one.priority) - PRIORITIES.indexOf(other.priority) ||
    Number(isUnacknowledged(other)) - Number(isUnacknowledged(one)) ||
    (other.since_ms ?? 0) - (one.since_ms ?? 0)
  )
}

/** How many alarms a priority has. */
export interface PriorityCount {
  priority: Priority
  count: number
}

/** The priorities that have such alarms, the highest first. */
export const countsBy = (countOf: (priority: Priority) => number): PriorityCount[] =>
  PRIORITIES.map((priority) => ({ priority, count: countOf(priority) })).filter(({ count }) => count > 0)

/** The active ones of these alarms by priority, the highest first. */
export const activeCounts = (alarms: Pick<Alarm, 'priority' | 'state'>[]): PriorityCount[] =>
  countsBy((wanted) => alarms.filter((alarm) => isActive(alarm) && alarm.priority === wanted).length)

/** `1 high, 3 medium`. */
export const countsText = (counts: PriorityCount[]): string =>
  counts.map(({ priority, count }) => `${count} ${t.priorities[priority]}`).join(', ')

/** The same for those below the highest, where there is room for one of them: `3 medium`, or `5 more` of both. */
export const lowerText = (lower: PriorityCount[]): string =>
  lower.length < 2 ? countsText(lower) : t.alarms.more(lower.reduce((sum, { count }) => sum + count, 0))

export interface AlarmSummary {
  /** The active alarms by priority; empty if all alarms have cleared and wait for an acknowledgement. */
  active: PriorityCount[]
  /** The alarms that are not acknowledged, by priority. */
  unacknowledgedCounts: PriorityCount[]
  unacknowledged: number
}

/** The summary in the header of all pages; `null` if no alarm is active or unacknowledged. */
export function summary(alarms: ActiveAlarms): AlarmSummary | null {
  const active = countsBy((priority) => alarms[priority].active)
  const unacknowledged = PRIORITIES.reduce((sum, priority) => sum + alarms[priority].unacknowledged, 0)
  if (active.length === 0 && unacknowledged === 0) return null
  const unacknowledgedCounts = countsBy((priority) => alarms[priority].unacknowledged)
  return { active, unacknowledgedCounts, unacknowledged }
}

/** The alarms that wait for an acknowledgement with a higher priority than all active ones: they have cleared, and the counts of the active ones hide them. */
export function moreUrgent({ active, unacknowledgedCounts }: AlarmSummary): PriorityCount | null {
  const [[highest], [waiting]] = [active, unacknowledgedCounts]
  if (!highest || !waiting) return null
  return PRIORITIES.indexOf(waiting.priority) < PRIORITIES.indexOf(highest.priority) ? waiting : null
}

/** An alarm with a pressure limit, which a trend shows as a line. */
export type PressureLimit = Alarm & { condition: 'above' | 'below'; limit: number }

const isPressureLimit = (alarm: Alarm): alarm is PressureLimit =>
  (alarm.condition === 'above' || alarm.condition === 'below') && alarm.limit !== null

/** The alarms with pressure limits of these series, the highest priority first. */
export const limitsOf = (all: Alarm[], series: string[]): PressureLimit[] =>
  all
    .filter(isPressureLimit)
    .filter((alarm) => series.includes(alarm.series ?? ''))
    .sort((one, other) => PRIORITIES.indexOf(one.priority) - PRIORITIES.indexOf(other.priority))

/** A value or limit of an alarm; pressures in the chosen unit. */
export function quantity(value: number | null, unit: string | null, shown: Unit): string {
  if (value === null) return ''
  if (unit === 'Pa') return unbroken(`${number(inUnit(value, shown))} ${shown}`)
  if (unit === 'decades/min') return unbroken(`${rounded(value)} ${t.common.decades}/min`)
  if (unit === 'telegrams/min') return unbroken(`${Number(value.toPrecision(3))} ${t.common.telegramsPerMinute}`)
  if (unit === 'gauges') return unbroken(t.common.gauges(value))
  return unbroken(`${Number(value.toPrecision(3))} ${unit ?? ''}`.trim())
}

/** A rate with two decimals, without a sign where it is zero with them. */
function rounded(value: number): string {
  const text = Math.abs(value).toFixed(2)
  return value < 0 && Number(text) > 0 ? `−${text}` : text
}

/** The condition of an alarm, in words. */
export function conditionText(alarm: Alarm, shown: Unit): string {
  const { condition, limit, unit, series, gauge, segment } = alarm
  const words = t.alarms.conditions
  const [place, at] = [series ?? gauge ?? segment ?? t.alarms.station, quantity(limit, unit, shown)]
  switch (condition) {
    case 'above':
      return words.above(place, at) + clearedText(alarm, shown)
    case 'below':
      return words.below(place, at) + clearedText(alarm, shown)
    case 'rise':
      return words.rise(place, at)
    case 'several':
      return severalText(alarm, shown)
    case 'point':
      // Its name says point, comparison and limit.
      return alarm.name + clearedText(alarm, shown)
    case 'not-measurable':
      return words.notMeasurable(place)
    case 'fault':
      return words.fault(place)
    case 'stale':
      return words.stale(place)
    case 'segment-down':
      return words.segmentDown(place)
    case 'bus-rate':
      return words.busRate(place, at)
    case 'damaged-telegrams':
      return words.damagedTelegrams(place, at)
    case 'not-recording':
      return words.notRecording
    case 'database-damaged':
      return words.databaseDamaged
    case 'not-archived':
      return words.notArchived
  }
}

/** Where the condition ends, if that is not its limit. */
function clearedText({ limit, reset, unit }: Alarm, shown: Unit): string {
  if (limit === null || reset === null || reset === limit) return ''
  const { untilAbove, untilBelow } = t.alarms.conditions
  return (reset > limit ? untilAbove : untilBelow)(quantity(reset, unit, shown))
}

function severalText({ several, limit }: Alarm, shown: Unit): string {
  if (!several) return ''
  const at = quantity(several.limit ?? null, several.unit ?? null, shown)
  return t.alarms.conditions.several(limit ?? 0, several.series.join(', '), several.condition, at)
}

/** Whether an entry of the history passes the filter. */
export function matchesFilter(event: AlarmEvent, change: string, text: string): boolean {
  const words = [event.alarm, event.subject, event.user, event.text].filter(Boolean).join(' ').toLowerCase()
  return (!change || event.change === change) && words.includes(text.toLowerCase())
}
