// The types of the archive's API.

import type { AlarmState, Priority, Quality } from '../api/types.ts'
import type { components } from './schema.d.ts'

type Schemas = components['schemas']

export type StationState = Schemas['StationState']
export type ActiveAlarm = Schemas['ActiveAlarm'] & { priority: Priority; state: AlarmState }
export type ArchivedEvent = Schemas['ArchivedEvent']
export type ArchivedPoint = Schemas['ArchivedPoint']
export type LatestReading = Schemas['LatestReading'] & { quality: Quality }

/** What the live stream shows. An entry that was removed is `null`. */
export interface State extends Omit<Schemas['State'], 'stations' | 'readings' | 'alarms'> {
  stations: Record<string, StationState | null>
  readings: Record<string, LatestReading | null>
  alarms: Record<string, ActiveAlarm | null>
}
