// What is told of alarms: words, marks, order.

import type { Alarm, AlarmEvent, AlarmState, Count, Priority, StandingAlarms } from '../api.ts'
import { number } from './format.ts'
import { inUnit, type Unit } from './units.ts'

export const PRIORITIES: Priority[] = ['high', 'medium', 'low']

/** A shape for each priority: colour alone says nothing to one man in twelve. */
export const SHAPES: Record<Priority, string> = { high: '▲', medium: '◆', low: '▼' }

export const ALARM_STATES: Record<AlarmState, { word: string; sentence: string }> = {
  normal: { word: 'normal', sentence: 'Its condition does not hold.' },
  unacknowledged: { word: 'new', sentence: 'Its condition holds, and nobody has acknowledged it.' },
  acknowledged: { word: 'acknowledged', sentence: 'Its condition holds, and somebody knows.' },
  returned: { word: 'over, new', sentence: 'Its condition held and does not any more; nobody has acknowledged it.' },
  'out-of-service': { word: 'out of service', sentence: 'Somebody has taken it away, with a reason.' },
}

export const WHATS: Record<string, string> = {
  raised: 'raised',
  returned: 'over',
  acknowledged: 'acknowledged',
  'taken-out-of-service': 'taken out of service',
  'returned-to-service': 'returned to service',
  removed: 'removed from the file',
}

export const isActive = ({ state }: Alarm): boolean => state === 'unacknowledged' || state === 'acknowledged'
export const wantsAcknowledgement = ({ state }: Alarm): boolean => state === 'unacknowledged' || state === 'returned'

/** What stands comes first, then the highest priority, then what nobody knows of, then the latest. */
export function byUrgency(one: Alarm, other: Alarm): number {
  const rank = (alarm: Alarm): number[] => [
    isActive(alarm) ? 0 : 1,
    PRIORITIES.indexOf(alarm.priority),
    wantsAcknowledgement(alarm) ? 0 : 1,
    -(alarm.since_ms ?? 0),
  ]
  const [left, right] = [rank(one), rank(other)]
  const place = left.findIndex((value, place) => value !== right[place])
  return place < 0 ? 0 : left[place]! - right[place]!
}

/** What all pages show in their frame: the highest priority that somebody must look at, and how many. */
export function summary(
  standing: StandingAlarms,
): { priority: Priority; here: number; active: number; unacknowledged: number } | null {
  const count = (of: (count: Count) => number): number =>
    PRIORITIES.reduce((sum, priority) => sum + of(standing[priority]), 0)
  const [active, unacknowledged] = [count((one) => one.active), count((one) => one.unacknowledged)]
  const highest = PRIORITIES.find((priority) => standing[priority].active + standing[priority].unacknowledged > 0)
  if (!highest) return null
  return { priority: highest, here: standing[highest].active, active, unacknowledged }
}

/** Alarms whose limits are pressures of these series: lines in a trend, the highest priority first. */
export const limitsOf = (all: Alarm[], chosen: string[]): Alarm[] =>
  all
    .filter(
      ({ condition, series, limit }) =>
        (condition === 'above' || condition === 'below') && limit !== null && chosen.includes(series ?? ''),
    )
    .sort((one, other) => PRIORITIES.indexOf(one.priority) - PRIORITIES.indexOf(other.priority))

/** A value or a limit of an alarm, in the unit that somebody has chosen. */
export function quantity(value: number | null, unit: string | null, shown: Unit): string {
  if (value === null) return ''
  if (unit === 'Pa') return `${number(inUnit(value, shown))} ${shown}`
  if (unit === 'decades/min') return `${value.toFixed(2)} decades/min`
  return `${Number(value.toPrecision(3))} ${unit ?? ''}`.trim()
}

/** When it is an alarm, in words. */
export function meaning({ condition, limit, reset, unit, series, gauge, segment }: Alarm, shown: Unit): string {
  const [where, at] = [series ?? gauge ?? segment ?? 'the station', quantity(limit, unit, shown)]
  const until =
    reset === null || reset === limit
      ? ''
      : `, until ${condition === 'below' ? 'above' : 'below'} ${quantity(reset, unit, shown)}`
  switch (condition) {
    case 'above':
      return `${where} above ${at}${until}`
    case 'below':
      return `${where} below ${at}${until}`
    case 'rise':
      return `${where} rises faster than ${at}`
    case 'blind':
      return `${where} has a limit and no valid reading`
    case 'fault':
      return `${where} reports a fault`
    case 'stale':
      return `${where} gives no fresh data`
    case 'down':
      return `segment ${where} does not run`
    case 'damage':
      return `more than ${at} of segment ${where} arrive damaged`
    case 'unrecorded':
      return 'nothing is being recorded'
  }
}

/** Whether a line of the history is looked for. */
export function isWanted(event: AlarmEvent, what: string, text: string): boolean {
  const words = [event.alarm, event.subject, event.who, event.text].filter(Boolean).join(' ').toLowerCase()
  return (!what || event.what === what) && words.includes(text.toLowerCase())
}
