// Stations with their readings and alarms, as the pages show them.

import type { AlarmState } from '../api/types.ts'
import { PRIORITIES } from '../lib/alarms.ts'
import type { ActiveAlarm, LatestReading, State, StationState } from './types.ts'

/** A station that sends nothing for longer than this is silent: it sends a span every two minutes at least. */
export const SILENT_MS = 300_000

export interface Station extends StationState {
  name: string
  readings: LatestReading[]
  alarms: ActiveAlarm[]
}

const present = <T>(entries: Record<string, T | null>): T[] => Object.values(entries).filter((entry) => entry !== null)

const byName = (one: { name: string }, other: { name: string }): number => one.name.localeCompare(other.name)

/** All stations by name, with their readings by name and their alarms in the order of the archive. */
export function stationsOf(state: State): Station[] {
  const all = new Map<string, Station>()
  for (const [name, station] of Object.entries(state.stations)) {
    if (station) all.set(name, { ...station, name, readings: [], alarms: [] })
  }
  for (const reading of present(state.readings)) all.get(reading.station)?.readings.push(reading)
  for (const alarm of present(state.alarms)) all.get(alarm.station)?.alarms.push(alarm)
  for (const station of all.values()) {
    station.readings.sort((one, other) => one.series.localeCompare(other.series))
    station.alarms.sort(byUrgency)
  }
  return [...all.values()].sort(byName)
}

export const isSilent = ({ stored_ms }: StationState, now: number): boolean =>
  stored_ms === null || stored_ms === undefined || now - stored_ms > SILENT_MS

/** Whether a user must look at the alarm: its condition holds, or it is not acknowledged. */
export const isOpen = ({ state }: ActiveAlarm): boolean =>
  state === 'unacknowledged' || state === 'acknowledged' || state === 'returned'

const STATES: AlarmState[] = ['unacknowledged', 'returned', 'acknowledged', 'shelved', 'out-of-service', 'suppressed']

/** Alarms that are not acknowledged first, then by priority, then the latest. */
export function byUrgency(one: ActiveAlarm, other: ActiveAlarm): number {
  return (
    STATES.indexOf(one.state) - STATES.indexOf(other.state) ||
    PRIORITIES.indexOf(one.priority) - PRIORITIES.indexOf(other.priority) ||
    other.at_ms - one.at_ms
  )
}

/** All alarms of all stations, the most urgent first. */
export const alarmsOf = (state: State): ActiveAlarm[] => present(state.alarms).sort(byUrgency)

/** The names of all series, as the API takes them. */
export const seriesOf = (state: State): string[] => Object.keys(state.readings).sort()
