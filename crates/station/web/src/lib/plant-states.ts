// Plant states: durations of a declaration, and the words about declared ones.

import type { DeclaredPlantState, PlantState } from '../api/types.ts'

const HOUR = 60
const DAY = 24 * HOUR

/** Durations and their minutes. */
const DURATIONS: [label: string, minutes: number][] = [
  ['30 minutes', 30],
  ['1 hour', HOUR],
  ['4 hours', 4 * HOUR],
  ['8 hours', 8 * HOUR],
  ['12 hours', 12 * HOUR],
  ['1 day', DAY],
  ['3 days', 3 * DAY],
  ['1 week', 7 * DAY],
  ['2 weeks', 14 * DAY],
]

/** The durations of a plant state, up to its longest time, which is always among them. */
export function durationsUpTo(longest: number): [label: string, minutes: number][] {
  const shorter = DURATIONS.filter(([, minutes]) => minutes < longest)
  const known = DURATIONS.find(([, minutes]) => minutes === longest)
  return [...shorter, known ?? [amount(longest), longest]]
}

/** A duration in the largest unit that has it without a remainder. */
function amount(minutes: number): string {
  const units: [number, string][] = [
    [DAY, 'day'],
    [HOUR, 'hour'],
    [1, 'minute'],
  ]
  const [length, unit] = units.find(([length]) => minutes % length === 0) ?? [1, 'minute']
  const count = minutes / length
  return `${count} ${unit}${count === 1 ? '' : 's'}`
}

/** The number of alarms that a plant state suppresses. */
export const alarmCount = ({ alarms }: Pick<PlantState, 'alarms'>): string =>
  alarms.length === 1 ? '1 alarm' : `${alarms.length} alarms`

/** The names of declared plant states, for the header; empty without one. */
export const declaredNames = (declared: Pick<DeclaredPlantState, 'name'>[]): string =>
  declared.map(({ name }) => name).join(', ')
