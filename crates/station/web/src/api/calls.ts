// A function for each request of the dashboard.

import { addressOf, get, post, RequestError, remove } from './request.ts'
import type {
  AcknowledgedAlarms,
  Alarm,
  AlarmEvent,
  AlarmPerformance,
  AlarmSettings,
  ArmedCommand,
  AuditEntry,
  Backup,
  Block,
  BusReport,
  Capture,
  ChangedAlarms,
  Command,
  Condition,
  Control,
  ControlAction,
  DefaultAlarm,
  DefaultAlarmSettings,
  Directory,
  Gateway,
  Outcome,
  Plant,
  PlantPicture,
  PlantQuery,
  PlantState,
  PointTrend,
  ProviderAddress,
  PumpDowns,
  Refusal,
  ReportQuery,
  Request,
  Rise,
  RiseQuery,
  Session,
  StationEvent,
  Trend,
  Webhook,
} from './types.ts'

/** The limit of requests during which the station talks to a gauge. chosen: a slow line in a ring of many masters takes some seconds for each. */
const BUS_MS = 60_000

/** The limit of what lasts as long as its data are large: all parameters of a gauge, a fit, a copy of the database. */
const LONG_MS = 600_000

export const fetchSession = (): Promise<Session> => get('/api/session', {})
export const login = (name: string, password: string): Promise<Session> =>
  post('/api/login', { body: { name, password } })
/** The address at which the browser ends its session at the OpenID provider; nothing if there is none. */
export const logout = (): Promise<ProviderAddress | null | undefined> => post('/api/logout', {})
export const beginOpenId = (): Promise<ProviderAddress> => post('/api/openid/begin', { body: {} })
export const completeOpenId = (
  state: string,
  code: string | null,
  error: string | null,
  iss: string | null,
): Promise<Session> => post('/api/openid/login', { body: { state, code, error, iss } })
export const changePassword = (current: string, next: string): Promise<Session> =>
  post('/api/password', { body: { current, new: next } })

export const fetchTrend = (
  series: string,
  from: number,
  to: number,
  pixels: number,
  signal?: AbortSignal,
): Promise<Trend> => get('/api/trend', { query: { series, from, to, pixels }, signal })

export const fetchPointTrend = (
  slave: string,
  point: string,
  from: number,
  to: number,
  pixels: number,
  signal?: AbortSignal,
): Promise<PointTrend> => get('/api/point-trend', { query: { slave, point, from, to, pixels }, signal })

export const fetchEvents = (from: number, to: number, limit: number, signal?: AbortSignal): Promise<StationEvent[]> =>
  get('/api/events', { query: { from, to, limit }, signal })

export const fitRise = (query: RiseQuery): Promise<Rise> => get('/api/rise', { query, limitMs: BUS_MS })

export const fetchDirectory = (signal?: AbortSignal): Promise<Directory> => get('/api/directory', { signal })

export const fetchPlant = (signal?: AbortSignal): Promise<PlantPicture> => get('/api/plant', { signal })

/** Takes seconds; ends in the station when the signal aborts it. */
export const identifyPlant = (query: PlantQuery, signal?: AbortSignal): Promise<Plant> =>
  get('/api/identify', { query, signal, limitMs: LONG_MS })

/** The pump-downs of a series, compared with the last ten before each, or with the one that begins at `reference`. */
export const fetchPumpDowns = (
  series: string,
  from: number,
  to: number,
  reference: string | null,
  signal?: AbortSignal,
): Promise<PumpDowns> =>
  get('/api/pump-downs', {
    query: { series, from, to, ...(reference === null ? {} : { reference: Number(reference) }) },
    signal,
    limitMs: BUS_MS,
  })

export const csvAddress = (series: string[], from: number, to: number): string =>
  addressOf('/api/export.csv', { query: { from, to, series } })

export const parquetAddress = (series: string[], from: number, to: number): string =>
  addressOf('/api/export.parquet', { query: { from, to, series } })

export const pointsCsvAddress = (from: number, to: number): string =>
  addressOf('/api/points.csv', { query: { from, to } })

export const pointsParquetAddress = (from: number, to: number): string =>
  addressOf('/api/points.parquet', { query: { from, to } })

/** The file of a report about a pump-down, in the time zone of the browser. */
export const reportAddress = (query: ReportQuery): string =>
  addressOf('/api/report.html', { query: { zone: Intl.DateTimeFormat().resolvedOptions().timeZone, ...query } })

/** Reads all parameters from the gauge. */
export const readBlocks = (gauge: string): Promise<Block[]> =>
  get('/api/gauges/{name}/blocks', { path: { name: gauge }, limitMs: LONG_MS })

export const fetchBus = (segment: string, signal?: AbortSignal): Promise<BusReport> =>
  get('/api/segments/{name}/bus', { path: { name: segment }, signal })

export const fetchCaptures = (segment: string, signal?: AbortSignal): Promise<Capture[]> =>
  get('/api/segments/{name}/captures', { path: { name: segment }, signal })

export const makeCapture = (segment: string): Promise<undefined> =>
  post('/api/segments/{name}/captures', { path: { name: segment } })

/** Makes a note about a time, or about the present. */
export const makeNote = (text: string, at: number | null): Promise<StationEvent> =>
  post('/api/notes', { body: { text, at_ms: at } })

export const captureAddress = (segment: string, file: string): string =>
  addressOf('/api/segments/{name}/captures/{file}', { path: { name: segment, file } })

export const fetchAlarms = (signal?: AbortSignal): Promise<Alarm[]> => get('/api/alarms', { signal })
export const fetchWebhooks = (signal?: AbortSignal): Promise<Webhook[]> => get('/api/webhooks', { signal })

export const fetchGateways = (signal?: AbortSignal): Promise<Gateway[]> => get('/api/gateways', { signal })

export const fetchAlarmHistory = (
  from: number,
  to: number,
  limit: number,
  signal?: AbortSignal,
): Promise<AlarmEvent[]> => get('/api/alarms/history', { query: { from, to, limit }, signal })

/** Acknowledges the occurrence that the user has seen, and no later one. */
export const acknowledge = (name: string, occurrence: number): Promise<Alarm> =>
  post('/api/alarms/{name}/acknowledge', { path: { name }, body: { occurrence } })

/** Each alarm is acknowledged or refused separately. */
export const acknowledgeAll = (alarms: { name: string; occurrence: number }[]): Promise<AcknowledgedAlarms> =>
  post('/api/alarms/acknowledge', { body: { alarms } })

/** Each alarm is shelved or refused separately. */
export const shelve = (alarms: string[], reason: string, minutes: number): Promise<ChangedAlarms> =>
  post('/api/alarms/shelve', { body: { alarms, reason, minutes } })

/** Each alarm is unshelved or refused separately. */
export const unshelve = (alarms: string[]): Promise<ChangedAlarms> => post('/api/alarms/unshelve', { body: { alarms } })

export const fetchAlarmPerformance = (from: number, to: number, signal?: AbortSignal): Promise<AlarmPerformance> =>
  get('/api/alarms/performance', { query: { from, to }, signal })

export const takeOutOfService = (name: string, reason: string, minutes: number | null): Promise<Alarm> =>
  post('/api/alarms/{name}/out-of-service', { path: { name }, body: { reason, minutes } })

export const returnToService = (name: string): Promise<Alarm> =>
  post('/api/alarms/{name}/return-to-service', { path: { name } })

export const fetchPlantStates = (signal?: AbortSignal): Promise<PlantState[]> => get('/api/plant-states', { signal })

/** Suppresses the alarms of the plant state until its end. */
export const declarePlantState = (name: string, reason: string, minutes: number): Promise<PlantState> =>
  post('/api/plant-states/{name}/declare', { path: { name }, body: { reason, minutes } })

/** Gives a declared plant state a later end. */
export const extendPlantState = (name: string, reason: string, minutes: number): Promise<PlantState> =>
  post('/api/plant-states/{name}/extend', { path: { name }, body: { reason, minutes } })

export const endPlantState = (name: string, reason: string | null): Promise<PlantState> =>
  post('/api/plant-states/{name}/end', { path: { name }, body: { reason } })

export const fetchAlarmSettings = (name: string, signal?: AbortSignal): Promise<AlarmSettings> =>
  get('/api/alarms/{name}/settings', { path: { name }, signal })

/** Refused unless the settings are still those that the user has seen. */
export const changeAlarmSettings = (
  name: string,
  seen: AlarmSettings,
  next: AlarmSettings,
  reason: string,
): Promise<Alarm> => post('/api/alarms/{name}/settings', { path: { name }, body: { seen, new: next, reason } })

export const fetchDefaultAlarms = (signal?: AbortSignal): Promise<DefaultAlarm[]> =>
  get('/api/default-alarms', { signal })

/** Refused unless the settings are still those that the user has seen. */
export const changeDefaultAlarm = (
  name: string,
  seen: DefaultAlarmSettings,
  next: DefaultAlarmSettings,
  reason: string,
): Promise<DefaultAlarmSettings> =>
  post('/api/default-alarms/{name}/settings', { path: { name }, body: { seen, new: next, reason } })

export const changeControl = (action: ControlAction): Promise<Control> => post(`/api/control-authority/${action}`, {})

export const fetchCommands = (gauge: string, signal?: AbortSignal): Promise<Command[]> =>
  get('/api/gauges/{name}/commands', { path: { name: gauge }, signal, limitMs: BUS_MS })

export const arm = (gauge: string, request: Request): Promise<ArmedCommand> =>
  post('/api/gauges/{name}/arm', { path: { name: gauge }, body: request, limitMs: BUS_MS })

export const sendArmed = (id: string): Promise<Outcome> =>
  post('/api/armed-commands/{id}/execute', { path: { id }, limitMs: BUS_MS })
export const disarm = (id: string): Promise<undefined> => remove('/api/armed-commands/{id}', { path: { id } })

/** The conditions that a refusal lists. */
export function conditionsOf(error: unknown): Condition[] {
  return (error instanceof RequestError && (error.body as Partial<Refusal> | null)?.conditions) || []
}

/** Makes a copy of the database; takes as long as the disk of the station needs. */
export const makeBackup = (): Promise<Backup> => post('/api/backup', { limitMs: LONG_MS })

export const backupAddress = (id: string): string => addressOf('/api/backup/{id}', { path: { id } })

export interface AuditFilter {
  gauge: string
  user: string
  from: number | null
}

const auditQuery = ({ gauge, user, from }: AuditFilter, limit: number) => ({
  limit,
  ...(gauge ? { gauge } : {}),
  ...(user ? { user } : {}),
  ...(from === null ? {} : { from }),
})

export const fetchAudit = (filter: AuditFilter, limit: number, signal?: AbortSignal): Promise<AuditEntry[]> =>
  get('/api/audit', { query: auditQuery(filter, limit), signal })

/** The CSV file has all entries. */
export const auditAddress = (filter: AuditFilter): string =>
  addressOf('/api/audit.csv', { query: auditQuery(filter, 100_000) })
