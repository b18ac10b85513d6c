// The order of a list of alarms, which does not change under the pointer of a user.

import type { Alarm, AlarmState } from '../api/types.ts'
import { byUrgency, PRIORITIES } from './alarms.ts'

/** `urgency` has groups by place; the others are one list. */
export const ORDERS = ['urgency', 'newest', 'oldest', 'priority', 'state', 'gauge', 'alarm'] as const

export type Order = (typeof ORDERS)[number]

const rankOf = ({ priority }: Alarm): number => PRIORITIES.indexOf(priority)
/** What waits for an operator comes first. */
const STATES: AlarmState[] = ['unacknowledged', 'returned', 'acknowledged']

const stateOf = ({ state }: Alarm): number => STATES.indexOf(state)
const byName = (one: Alarm, other: Alarm): number => one.name.localeCompare(other.name)
const placeOf = ({ gauge, segment }: Alarm): string => gauge ?? segment ?? ''

const COMPARE: Record<Order, (one: Alarm, other: Alarm) => number> = {
  urgency: byUrgency,
  newest: (one, other) => (other.raised_ms ?? 0) - (one.raised_ms ?? 0),
  oldest: (one, other) => (one.raised_ms ?? 0) - (other.raised_ms ?? 0),
  priority: (one, other) => rankOf(one) - rankOf(other) || byUrgency(one, other),
  state: (one, other) => stateOf(one) - stateOf(other) || byUrgency(one, other),
  gauge: (one, other) => placeOf(one).localeCompare(placeOf(other)) || byUrgency(one, other),
  alarm: byName,
}

export const inOrder = (alarms: Alarm[], order: Order): Alarm[] => [...alarms].sort(COMPARE[order])

/** The orders of a column of the list; each press on its head goes on to the next, and then back to the groups. */
export const HEAD_ORDERS = {
  priority: ['priority'],
  state: ['state'],
  raised: ['newest', 'oldest'],
  gauge: ['gauge'],
  alarm: ['alarm'],
} as const satisfies Record<string, readonly Order[]>

export type HeadColumn = keyof typeof HEAD_ORDERS

/** The order after a press on the head of a column. */
export function afterHead(before: Order, column: HeadColumn): Order {
  const orders: readonly Order[] = HEAD_ORDERS[column]
  return orders[orders.indexOf(before) + 1] ?? 'urgency'
}

/** The direction of the list by a column; `null` if it is sorted by another one. */
export function headDirection(order: Order, column: HeadColumn): 'ascending' | 'descending' | null {
  const orders: readonly Order[] = HEAD_ORDERS[column]
  if (!orders.includes(order)) return null
  return order === 'newest' ? 'descending' : 'ascending'
}

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
