// Groups of active alarms: those of a volume of the plant, otherwise those of a gauge, of a segment, or of the station.

import type { Alarm, Priority } from '../api/types.ts'
import { type AlarmSummary, activeCounts, byUrgency, countsBy, isActive, isUnacknowledged } from './alarms.ts'
import { matchesWords } from './search.ts'

/** That many alarms are read before they are acknowledged together. More than ten in ten minutes are a flood (ISA-18.2). */
export const FEW_ALARMS = 8

/** A list up to this long is open: that many alarms fit on a screen of 1080 pixels. */
export const SCREEN_ALARMS = 40

/** What an alarm is about. */
export interface Place {
  kind: 'volume' | 'gauge' | 'segment' | 'station'
  /** Empty for the station. */
  name: string
}

export interface AlarmGroup {
  key: string
  place: Place
  /** The most urgent first. */
  alarms: Alarm[]
  /** The alarm that was raised first of those active now: the others may be its consequences. */
  first: Alarm | null
}

/** The place of an alarm. `volumeOf` tells in which volume it is, if it is in one. */
export function placeOf(alarm: Alarm, volumeOf: (alarm: Alarm) => string | null): Place {
  const volume = volumeOf(alarm)
  if (volume !== null) return { kind: 'volume', name: volume }
  if (alarm.gauge !== null) return { kind: 'gauge', name: alarm.gauge }
  if (alarm.segment !== null) return { kind: 'segment', name: alarm.segment }
  return { kind: 'station', name: '' }
}

/** How two alarms follow each other. */
type Compare = (one: Alarm, other: Alarm) => number

/** The alarms by their places; the group with the most urgent alarm comes first, unless `compare` says another order. */
export function alarmGroups(
  alarms: Alarm[],
  placeOf: (alarm: Alarm) => Place,
  compare: Compare = byUrgency,
): AlarmGroup[] {
  const groups = new Map<string, AlarmGroup>()
  for (const alarm of [...alarms].sort(compare)) {
    const place = placeOf(alarm)
    const key = `${place.kind} ${place.name}`
    const group = groups.get(key) ?? { key, place, alarms: [], first: null }
    group.alarms.push(alarm)
    if (isActive(alarm) && (group.first === null || raisedAt(alarm) < raisedAt(group.first))) group.first = alarm
    groups.set(key, group)
  }
  return [...groups.values()]
}

const raisedAt = ({ raised_ms }: Alarm): number => raised_ms ?? Number.POSITIVE_INFINITY

/** A group of one alarm has no heading. */
export const hasHeading = ({ alarms }: AlarmGroup): boolean => alarms.length > 1

/** The groups with those of their alarms that pass a filter. The filter does not change which alarm of a group was raised first. */
export function passing(
  groups: AlarmGroup[],
  passes: (alarm: Alarm, place: Place) => boolean,
  compare: Compare = byUrgency,
): AlarmGroup[] {
  const left = groups.map((group) => ({ ...group, alarms: group.alarms.filter((alarm) => passes(alarm, group.place)) }))
  return left
    .flatMap((group) => group.alarms.slice(0, 1).map((urgent) => ({ group, urgent })))
    .sort((one, other) => compare(one.urgent, other.urgent))
    .map(({ group }) => group)
}

/** How many alarms of a group are active and not acknowledged. */
export function summaryOf(alarms: Alarm[]): AlarmSummary {
  const unacknowledged = alarms.filter(isUnacknowledged)
  return {
    active: activeCounts(alarms),
    unacknowledgedCounts: countsBy((wanted) => unacknowledged.filter(({ priority }) => priority === wanted).length),
    unacknowledged: unacknowledged.length,
  }
}

export interface AlarmFilter {
  /** An empty string stands for all. */
  priority: Priority | ''
  /** Words that are searched in the names of the alarm and of its place, and in the location of its gauge. */
  text: string
}

export const NO_FILTER: AlarmFilter = { priority: '', text: '' }

export const isFiltered = ({ priority, text }: AlarmFilter): boolean => priority !== '' || text.trim() !== ''

export function passesFilter(alarm: Alarm, filter: AlarmFilter, place: Place, location: string | null): boolean {
  const { name, gauge, series, segment, several, priority } = alarm
  const texts = [name, gauge, series, segment, place.name, location, ...(several?.series ?? [])]
  const isWanted = filter.priority === '' || priority === filter.priority
  return (
    isWanted &&
    matchesWords(
      texts.filter((text) => text !== null),
      filter.text.trim(),
    )
  )
}

/** Whether a group is open, and whether the user has said so. */
export interface Opened {
  open: boolean
  chosen: boolean
}

/**
 * Which groups with a heading are open. What a user has chosen stays as long as the group has a heading. Otherwise groups of a short list
 * are open. A list that becomes long closes no group: the user may read it, and what he presses would move.
 */
export function openGroups(
  before: ReadonlyMap<string, Opened>,
  groups: AlarmGroup[],
  isShort: boolean,
): Map<string, Opened> {
  return new Map(
    groups.filter(hasHeading).map(({ key }) => {
      const was = before.get(key)
      return [key, was?.chosen ? was : { open: isShort || (was?.open ?? false), chosen: false }]
    }),
  )
}

/** Whether a user has to see the names before he acknowledges all: some alarms are in closed groups, or there are too many to read. */
export const mustAsk = (
  unacknowledged: Alarm[],
  groups: AlarmGroup[],
  isOpen: (group: AlarmGroup) => boolean,
): boolean =>
  unacknowledged.length > FEW_ALARMS ||
  groups.some((group) => !isOpen(group) && group.alarms.some((alarm) => unacknowledged.includes(alarm)))

/** Tells the present values. A snapshot has them for the most urgent alarms; the others are taken from all alarms, which are fetched less often. */
export function valuesOf(all: Alarm[]): (alarm: Alarm) => number | null {
  const fetched = new Map(all.map((alarm) => [alarm.name, alarm.value]))
  return ({ name, value }) => value ?? fetched.get(name) ?? null
}
