// The history of alarms: its order, its times, and its CSV file.

import type { AlarmEvent } from '../api/types.ts'
import { PRIORITIES } from './alarms.ts'
import { momentOf } from './format.ts'

/** The columns by which the history is sorted. */
export const HISTORY_COLUMNS = ['time', 'priority', 'change', 'alarm', 'user', 'value'] as const

export type HistoryColumn = (typeof HISTORY_COLUMNS)[number]

export interface HistoryOrder {
  column: HistoryColumn
  isDescending: boolean
}

/** The order of the station. */
export const NEWEST_FIRST: HistoryOrder = { column: 'time', isDescending: true }

export const isNewestFirst = ({ column, isDescending }: HistoryOrder): boolean => column === 'time' && isDescending

type Key = string | number | null

const KEYS: Record<HistoryColumn, (event: AlarmEvent) => Key> = {
  time: ({ at_ms }) => at_ms,
  priority: ({ priority }) => PRIORITIES.indexOf(priority),
  change: ({ change }) => change,
  alarm: ({ alarm }) => alarm,
  user: ({ user }) => user,
  value: ({ value }) => value,
}

/** Entries without such a value are last in both directions. */
function compared(one: Key, other: Key, isDescending: boolean): number {
  if (one === null || other === null) return Number(one === null) - Number(other === null)
  const order =
    typeof one === 'number' && typeof other === 'number'
      ? one - other
      : String(one).localeCompare(String(other), 'en', { numeric: true })
  return isDescending ? -order : order
}

/** The entries in another order; equal ones stay in that of the station, the newest first. */
export function historyInOrder(events: AlarmEvent[], { column, isDescending }: HistoryOrder): AlarmEvent[] {
  if (isNewestFirst({ column, isDescending })) return events
  const key = KEYS[column]
  return [...events].sort((one, other) => compared(key(one), key(other), isDescending))
}

/** After a press on the head of a column: a time begins with the newest, all else with the first; a second press turns it round. */
export function afterPress(before: HistoryOrder, column: HistoryColumn): HistoryOrder {
  return { column, isDescending: before.column === column ? !before.isDescending : column === 'time' }
}

/** The times of a choice in milliseconds: a number of milliseconds before now, or two typed times of which each may be empty. */
export function historyTimes(
  period: string,
  [from, to]: readonly [string, string],
  now: number,
): { from: number; to: number | null } {
  if (period === 'between') return { from: momentOf(from) ?? 0, to: momentOf(to) }
  return { from: period === '' ? 0 : Math.max(0, Math.floor(now - Number(period))), to: null }
}

const CSV_HEAD = 'time,alarm,subject,priority,change,state,user,value,unit,text,occurrence'

/** A text in quotes (RFC 4180). One that a spreadsheet would take for a formula gets an apostrophe before it, as in the files of the station. */
function quoted(text: string | null): string {
  if (text === null) return ''
  return `"${/^[=+\-@\t\r]/.test(text) ? "'" : ''}${text.replaceAll('"', '""')}"`
}

/** The entries as CSV with the names and units of the API; times are ISO 8601 in UTC. */
export function historyCsv(events: AlarmEvent[]): string {
  const lines = events.map(({ at_ms, alarm, subject, priority, change, state, user, value, unit, text, occurrence }) =>
    [
      ...[new Date(at_ms).toISOString(), quoted(alarm), quoted(subject), priority, change, state, quoted(user)],
      ...[value ?? '', quoted(unit), quoted(text), occurrence],
    ].join(','),
  )
  return [CSV_HEAD, ...lines, ''].join('\n')
}
