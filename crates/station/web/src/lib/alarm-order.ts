// The order of a list of alarms, which does not change under the pointer of a user.

import type { Alarm } from '../api/types.ts'
import { byUrgency, PRIORITIES } from './alarms.ts'

/** `urgency` has groups by place; the others are one list. */
export const ORDERS = ['urgency', 'newest', 'oldest', 'priority', 'gauge', 'alarm'] as const

export type Order = (typeof ORDERS)[number]

const rankOf = ({ priority }: Alarm): number => PRIORITIES.indexOf(priority)
const byName = (one: Alarm, other: Alarm): number => one.name.localeCompare(other.name)
const placeOf = ({ gauge, segment }: Alarm): string => gauge ?? segment ?? ''

const COMPARE: Record<Order, (one: Alarm, other: Alarm) => number> = {
  urgency: byUrgency,
  newest: (one, other) => (other.raised_ms ?? 0) - (one.raised_ms ?? 0),
  oldest: (one, other) => (one.raised_ms ?? 0) - (other.raised_ms ?? 0),
  priority: (one, other) => rankOf(one) - rankOf(other) || byUrgency(one, other),
  gauge: (one, other) => placeOf(one).localeCompare(placeOf(other)) || byUrgency(one, other),
  alarm: byName,
}

export const inOrder = (alarms: Alarm[], order: Order): Alarm[] => [...alarms].sort(COMPARE[order])

/**
 * The list while a user works in it: each alarm keeps its place, also one that has ended. `shown` is the list as it is drawn; alarms
 * that have come since then wait, and are counted.
 */
export function held(shown: Alarm[], now: Alarm[]): { list: Alarm[]; waiting: number } {
  const present = new Map(now.map((alarm) => [alarm.name, alarm]))
  const list = shown.map((alarm) => present.get(alarm.name) ?? alarm)
  const stay = shown.filter(({ name }) => present.has(name)).length
  return { list, waiting: now.length - stay }
}
