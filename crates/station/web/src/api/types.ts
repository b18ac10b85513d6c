// The dashboard's names for the types of the API. The types themselves are generated: schema.d.ts. Pressures are in Pa, times
// in milliseconds since 1970.

import type { components, operations } from './schema.d.ts'

type Schemas = components['schemas']

/** The state of the station as /api/live sends it: segments, gauges and alarms by name, so that a change needs only those that have changed. */
export type LiveState = Schemas['Snapshot']
/** The same for pages. */
export interface Snapshot {
  station: Station
  segments: Segment[]
  gauges: Gauge[]
  control_authority: Control
  read_progress: Schemas['ReadProgress'][]
  alarms: ActiveAlarms
  plant: LivePlant
  directory_revision: number
}
export type Station = Schemas['Station']
export type Recorder = Schemas['RecorderView']

export type Segment = Schemas['Segment']
export type SegmentState = Schemas['SegmentState']
/** A master or slave on a segment. */
export type BusStation = Schemas['BusStation']
/** The relation of a master or slave to this station: our gauge in data exchange, another master, ... */
export type BusStatus = Schemas['BusStationState']

/** What the station hears on the line of a segment. */
export type BusReport = Schemas['BusReport']
export type BusStationReport = Schemas['StationReport']
export type BusDistribution = Schemas['Distribution']
/** The state of a station in the live list. */
export type LineState = Schemas['StationState']
/** What a master did with a parameter. */
export type ParameterDone = Schemas['Done']
export type Capture = Schemas['CaptureView']

/** A gauge without the time of its readings, which would change the live stream at every reading. Its parameters are the points of a slave. */
export type Gauge = Omit<Schemas['Gauge'], 'read_ms'>
/** A value of a slave by its GSD file. */
export type Point = Omit<Schemas['WatchedParameter'], 'read_ms'>
/** A point as the station records it, with its unit. */
export type RecordedPoint = Schemas['RecordedPoint']
/** The trend of a point, in its unit. */
export type PointTrend = Schemas['PointTrend']
export type Reading = Schemas['Reading']
export type Quality = Reading['quality']
export type Principle = NonNullable<Reading['principle']>
export type Block = Schemas['Block']
export type Parameter = Schemas['Parameter']

/** The labels of the gauges, from the station's file. */
export type Directory = Schemas['Directory']
/** A view of all users. */
export type SavedView = Schemas['SavedView']
export type GaugeLabels = Schemas['GaugeLabels']

/** The plant of the station's file: volumes, and what is between them. */
export type PlantPicture = Schemas['PlantPicture']
export type PlantVolume = Schemas['PlantVolume']
export type PlantPart = Schemas['PlantPart']
export type PlantPartStatus = Schemas['PlantPartStatus']
export type LivePlant = Schemas['LivePlant']

export type Trend = Schemas['Trend']
export type StationEvent = Schemas['Event']
export type EventKind = StationEvent['kind']
export type Rise = Schemas['RiseView']
/** A pump-down beside the usual ones. */
export type PumpDown = Schemas['PumpDownView']
export type PumpDownLevel = Schemas['LevelView']
export type ProviderAddress = Schemas['ProviderAddress']
export type PumpDowns = Schemas['PumpDowns']
/** A plant identified from the record of one gauge. */
export type Spray = Schemas['SprayView']
export type Plant = Schemas['PlantView']
/** By hand: the generator adds an empty object to these codes, with which no table can be read. A code that is missing here does not compile. */
export type Remedy = 'close-leak' | 'bake' | 'larger-pump' | 'better-pump'
/** How well the record determines a number. */
export type Certainty = 'determined' | 'upper-bound' | 'undetermined'
export type PlantQuery = operations['identify']['parameters']['query']
/** A value with its 95 % interval; without an upper bound it is `null`. */
export type Bounds = Schemas['BoundsView']
/** The time to a target; without a mean it is more likely never reached. */
export type TargetTime = Schemas['TimeView']
export type ReportQuery = operations['report']['parameters']['query']
export type RiseQuery = operations['rise']['parameters']['query']
export type Interval = Schemas['IntervalView']
export type FlowUnits = Schemas['FlowView']

export type Alarm = Schemas['AlarmView']
export type AlarmState = Schemas['AlarmState']
export type AlarmCounts = Schemas['AlarmCount']
/** The numbers of the alarms, and all those that are active or unacknowledged, the most urgent first. */
export type ActiveAlarms = Schemas['AlarmOverview'] & { alarms: Alarm[] }
export type AlarmEvent = Schemas['AlarmHistoryEntry']
export type AlarmChange = AlarmEvent['change']
export type AcknowledgedAlarms = Schemas['AcknowledgeAllResult']
export type ChangedAlarms = Schemas['ChangedAlarms']
export type AlarmSettings = Schemas['AlarmSettings']
/** What an operator declares about the plant, and the alarms that it suppresses. */
export type PlantState = Schemas['PlantStateView']
export type DeclaredPlantState = Schemas['DeclaredPlantState']
/** An alarm that every gauge, every segment or the station has. */
export type DefaultAlarm = Schemas['DefaultAlarmView']
export type DefaultAlarmSettings = Schemas['DefaultAlarmSettings']
export type AlarmPerformance = Schemas['AlarmPerformance']
export type Priority = Schemas['Priority']
export type Webhook = Schemas['WebhookView']

/** A gateway to a control system. */
export type ArchiveLink = Schemas['ArchiveView']
export type Gateway = Schemas['GatewayView']

export type Session = Schemas['Session']
export type Role = Schemas['Role']

/** Who has control of the gauges, and who requests it. */
export type Control = Schemas['ControlAuthorityView']
export type ControlAction = 'request' | 'release' | 'grant' | 'take-over'
export type Command = Schemas['Command']
export type Condition = Schemas['ConditionView']
export type Risk = Schemas['Risk']
export type RiskClass = Schemas['RiskClass']
/** A command, or a parameter and its new value, to be armed. */
export type Request = { command: string } | { target: string; value: string }
export type ArmedCommand = Schemas['ArmedCommandView']
export type Outcome = Schemas['ExecutedView']
/** The answer when a command is refused: the reason, and all conditions. */
export type Refusal = Schemas['ConflictView']
export type Backup = Schemas['BackupView']
export type AuditEntry = Schemas['AuditEntry']
export type AuditAction = AuditEntry['action']
