// Plant states: durations of a declaration, and the words about declared ones.

import type { Alarm, DeclaredPlantState, PlantState } from '../api/types.ts'
import { t } from '../texts/texts.ts'
import { byUrgency } from './alarms.ts'

const HOUR = 60
const DAY = 24 * HOUR

/** Durations in minutes. */
const DURATIONS = [30, HOUR, 4 * HOUR, 8 * HOUR, 12 * HOUR, DAY, 3 * DAY, 7 * DAY, 14 * DAY]

/** The durations of a plant state with their minutes, up to its longest time, which is always among them. */
export function durationsUpTo(longest: number): [label: string, minutes: number][] {
  const all = [...DURATIONS.filter((minutes) => minutes < longest), longest]
  return all.map((minutes) => [durationText(minutes), minutes])
}

/** Weeks where a choice has them, otherwise the largest unit that has the duration without a remainder. */
function durationText(minutes: number): string {
  if (minutes === 7 * DAY || minutes === 14 * DAY) return t.suppress.weeks(minutes / (7 * DAY))
  if (minutes % DAY === 0) return t.suppress.days(minutes / DAY)
  return minutes % HOUR === 0 ? t.suppress.hours(minutes / HOUR) : t.suppress.minutes(minutes)
}

/** The number of alarms that a plant state suppresses. */
export const alarmCount = ({ alarms }: Pick<PlantState, 'alarms'>): string => t.plantStates.alarms(alarms.length)

/** An alarm that a plant state suppresses; `alarm` is `null` until the alarms have been fetched. */
export interface NamedAlarm {
  name: string
  alarm: Alarm | null
}

/** The alarms that a plant state suppresses: active ones first, then by priority, then those that are not known. */
export function suppressedBy({ alarms }: Pick<PlantState, 'alarms'>, all: readonly Alarm[]): NamedAlarm[] {
  const byName = new Map(all.map((alarm) => [alarm.name, alarm]))
  return alarms.map((name) => ({ name, alarm: byName.get(name) ?? null })).sort(byUrgencyIfKnown)
}

function byUrgencyIfKnown(one: NamedAlarm, other: NamedAlarm): number {
  if (one.alarm && other.alarm) return byUrgency(one.alarm, other.alarm)
  return Number(other.alarm !== null) - Number(one.alarm !== null)
}

/** The names of declared plant states, for the header; empty without one. */
export const declaredNames = (declared: Pick<DeclaredPlantState, 'name'>[]): string =>
  declared.map(({ name }) => name).join(', ')
