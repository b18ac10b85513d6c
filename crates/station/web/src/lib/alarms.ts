// Texts, symbols and order of alarms.

import type { ActiveAlarms, Alarm, AlarmChange, AlarmCounts, AlarmEvent, AlarmState, Priority } from '../api/types.ts'
import { number } from './format.ts'
import { inUnit, type Unit } from './units.ts'

export const PRIORITIES: Priority[] = ['high', 'medium', 'low']

/** A number for each priority, in a shape of its own: it can be told without colours, and it is no direction of a pressure. */
export const NUMBERS: Record<Priority, string> = { high: '1', medium: '2', low: '3' }

export const ALARM_STATES: Record<AlarmState, { label: string; sentence: string }> = {
  normal: { label: 'normal', sentence: 'The condition does not hold.' },
  unacknowledged: { label: 'not acknowledged', sentence: 'The condition holds; the alarm is not acknowledged.' },
  acknowledged: { label: 'acknowledged', sentence: 'The condition holds; an operator has acknowledged the alarm.' },
  returned: {
    label: 'cleared, not acknowledged',
    sentence: 'The condition no longer holds; the alarm is not acknowledged.',
  },
  shelved: {
    label: 'shelved',
    sentence: 'An operator has shelved the alarm for a while and given a reason.',
  },
  'out-of-service': {
    label: 'out of service',
    sentence: 'An engineer has taken the alarm out of service and given a reason.',
  },
  suppressed: {
    label: 'suppressed',
    sentence: 'A declared plant state suppresses the alarm.',
  },
}

export const ALARM_CHANGES: Record<AlarmChange, string> = {
  raised: 'raised',
  returned: 'cleared',
  acknowledged: 'acknowledged',
  shelved: 'shelved',
  unshelved: 'unshelved',
  'taken-out-of-service': 'taken out of service',
  'returned-to-service': 'returned to service',
  suppressed: 'suppressed',
  unsuppressed: 'no longer suppressed',
  removed: 'removed from the file',
  'settings-changed': 'settings changed',
}

/** Whether the condition of the alarm holds. */
export const isActive = ({ state }: Alarm): boolean => state === 'unacknowledged' || state === 'acknowledged'
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

export interface AlarmSummary {
  /** The highest priority that has an active alarm; `null` if all alarms have cleared and wait for an acknowledgement. */
  priority: Priority | null
  /** Active alarms of that priority. */
  activeOfPriority: number
  active: number
  unacknowledged: number
}

/** The summary in the header of all pages; `null` if no alarm is active or unacknowledged. */
export function summary(alarms: ActiveAlarms): AlarmSummary | null {
  const total = (count: (counts: AlarmCounts) => number): number =>
    PRIORITIES.reduce((sum, priority) => sum + count(alarms[priority]), 0)
  const [active, unacknowledged] = [total((counts) => counts.active), total((counts) => counts.unacknowledged)]
  if (active + unacknowledged === 0) return null
  const priority = PRIORITIES.find((priority) => alarms[priority].active > 0) ?? null
  return { priority, activeOfPriority: priority ? alarms[priority].active : 0, active, unacknowledged }
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
  if (unit === 'Pa') return `${number(inUnit(value, shown))} ${shown}`
  if (unit === 'decades/min') return `${value.toFixed(2)} decades/min`
  return `${Number(value.toPrecision(3))} ${unit ?? ''}`.trim()
}

/** The condition of an alarm, in words. */
export function conditionText(alarm: Alarm, shown: Unit): string {
  const { condition, limit, reset, unit, series, gauge, segment } = alarm
  const [place, at] = [series ?? gauge ?? segment ?? 'the station', quantity(limit, unit, shown)]
  const cleared =
    reset === null || reset === limit
      ? ''
      : `, until ${condition === 'below' ? 'above' : 'below'} ${quantity(reset, unit, shown)}`
  switch (condition) {
    case 'above':
      return `${place} above ${at}${cleared}`
    case 'below':
      return `${place} below ${at}${cleared}`
    case 'rise':
      return `${place} rises faster than ${at}`
    case 'several':
      return severalText(alarm, shown)
    case 'not-measurable':
      return `${place} has a limit that its reading does not decide`
    case 'fault':
      return `${place} reports a fault`
    case 'stale':
      return `${place} delivers no new data`
    case 'segment-down':
      return `segment ${place} is not running`
    case 'bus-rate':
      return `segment ${place}: a station with more than ${at} of its requests repeated, lost or damaged`
    case 'damaged-telegrams':
      return `segment ${place}: more than ${at} arrive damaged`
    case 'not-recording':
      return 'the recorder does not write'
  }
}

function severalText({ several, limit }: Alarm, shown: Unit): string {
  if (!several) return ''
  const side = several.condition === 'rise' ? 'rise faster than' : several.condition
  const list = several.series.join(', ')
  return `at least ${limit} of ${list} ${side} ${quantity(several.limit ?? null, several.unit ?? null, shown)}`
}

/** Whether an entry of the history passes the filter. */
export function matchesFilter(event: AlarmEvent, change: string, text: string): boolean {
  const words = [event.alarm, event.subject, event.user, event.text].filter(Boolean).join(' ').toLowerCase()
  return (!change || event.change === change) && words.includes(text.toLowerCase())
}
