// The API of the station: its types, as src/view.rs has them, and one function for each path. Pressures in Pa, times in
// milliseconds since 1970.

export type Quality = 'valid' | 'overrange' | 'underrange' | 'invalid' | 'gap'
export type Standing = 'ourselves' | 'master' | 'exchanging' | 'faulty' | 'starting' | 'missing' | 'foreign'
export type SegmentState = 'waiting' | 'listening' | 'running'
export type Principle = 'pirani' | 'hot-cathode' | 'cold-cathode' | 'diaphragm' | 'atmosphere'
export type EventKind = 'station' | 'bus' | 'gauge' | 'command' | 'note' | 'access' | 'alarm'

export type Role = 'viewer' | 'operator' | 'engineer'

/** Whether one logs in here: not at all, has done so, has not yet. */
export type Door = 'open' | 'in' | 'out'

export interface Session {
  name: string
  role: Role
  /** Proves with everything that is not only looked at that this page is the station's own. */
  token: string
  door: Door
}

export interface Recorder {
  written_ms: number | null
  error: string | null
  lost: number
  lost_events: number
}

export interface Station {
  name: string
  version: string
  started_ms: number
  now_ms: number
  recorder: Recorder
}

export interface OnBus {
  address: number
  standing: Standing
  name: string | null
  device: string | null
  ident: string | null
  words: string
}

export interface Segment {
  name: string
  port: string
  baud: number
  master: number
  state: SegmentState
  trouble: string | null
  cycle_ms: number | null
  damaged: number
  stations: OnBus[]
}

export interface Reading {
  series: string
  instance: number
  principle: Principle | null
  pa: number | null
  corrected_pa: number | null
  quality: Quality
}

export interface TripLevel {
  name: string
  pa: number
}

export interface Gauge {
  name: string
  segment: string
  address: number
  device: string
  standing: Standing
  trouble: string | null
  exceptions: string[]
  gas: string
  levels: TripLevel[]
  readings: Reading[]
  age_ms: number | null
  poll_ms: number
}

/** Who may act now. */
export interface Mastership {
  holder: string | null
  since_ms: number | null
  asked_by: string | null
  asked_ms: number | null
}

/** How far the parameters of a gauge are read. */
export interface ReadSoFar {
  gauge: string
  done: number
  of: number
}

export type Priority = 'high' | 'medium' | 'low'
export type AlarmState = 'normal' | 'unacknowledged' | 'acknowledged' | 'returned' | 'out-of-service'
export type AlarmCondition = 'above' | 'below' | 'rise' | 'blind' | 'fault' | 'stale' | 'down' | 'damage' | 'unrecorded'

export interface OutOfService {
  who: string
  at_ms: number
  reason: string
  until_ms: number | null
}

export interface Alarm {
  name: string
  condition: AlarmCondition
  gauge: string | null
  series: string | null
  segment: string | null
  priority: Priority
  state: AlarmState
  since_ms: number | null
  /** Which time it was raised; whoever acknowledges it says which they have seen. */
  occurrence: number
  raised_ms: number | null
  raised_value: number | null
  text: string
  value: number | null
  limit: number | null
  reset: number | null
  unit: string | null
  acknowledged_by: string | null
  acknowledged_ms: number | null
  out_of_service: OutOfService | null
  message: string | null
}

export interface Count {
  active: number
  unacknowledged: number
}

/** Alarms at a moment: how many, and those that stand or are new. */
export interface StandingAlarms {
  trouble: string | null
  high: Count
  medium: Count
  low: Count
  out_of_service: number
  list: Alarm[]
  more: number
}

export interface AlarmEvent {
  at_ms: number
  alarm: string
  what: string
  state: AlarmState
  priority: Priority
  subject: string | null
  occurrence: number
  who: string | null
  value: number | null
  unit: string | null
  text: string
}

export interface Webhook {
  name: string
  at: string
  waiting: number
  delivered: number
  given_up: number
  delivered_ms: number | null
  problem: string | null
  failing_since_ms: number | null
}

/** What /api/live sends four times a second. */
export interface Moment {
  station: Station
  segments: Segment[]
  gauges: Gauge[]
  mastership: Mastership
  reading: ReadSoFar[]
  alarms: StandingAlarms
}

/** One entry of each list for every pixel in which something was recorded. */
export interface Trend {
  series: string
  start_ms: number[]
  low: (number | null)[]
  high: (number | null)[]
  mean: (number | null)[]
  /** Bit 0 valid, 1 overrange, 2 underrange, 3 invalid, 4 gap. */
  qualities: number[]
}

export interface Happening {
  at_ms: number
  gauge: string | null
  kind: EventKind
  text: string
}

export interface Rise {
  start_pa: number
  steady_pa_per_s: number
  leak_pa_m3_per_s: number | null
  bend_pa: number | null
  tau_s: number | null
  outgassing_pa_m3_per_s: number | null
  explained: number
  samples: number
}

export interface Parameter {
  target: string
  name: string
  numbers: string
  access: string
  value: string | null
  refusal: string | null
  write: Writing | null
}

export type RiskClass = 'harmless' | 'volatile' | 'on-request' | 'kept' | 'dangerous'

export interface Risk {
  class: RiskClass
  words: string
}

/** What it takes to write a parameter. */
export interface Writing {
  takes: string
  choices: string[]
  risk: Risk
  role: Role
  barred: string | null
}

export interface Block {
  name: string
  parameters: Parameter[]
}

/** A refusal, in the station's own sentence. */
export class Refused extends Error {
  constructor(
    sentence: string,
    readonly status = 0,
    /** What else it says. */
    readonly body: unknown = null,
  ) {
    super(sentence)
  }
}

const LOST = 'The station does not answer.'

/** What the session gives to everything that is asked: its token, and what to do when it has ended or has another token. */
export const proof = {
  token: '',
  ended: (): void => {},
  /** Whether the same person has another token now, from another window. */
  renewed: (): Promise<boolean> => Promise.resolve(false),
}

export function get<T>(path: string, query: Record<string, string | number>, signal?: AbortSignal): Promise<T> {
  return answer(address(path, query), signal ? { signal } : {})
}

/** Something is to be done. */
export function post<T>(path: string, body: unknown): Promise<T> {
  return send('POST', path, body)
}

/** Something is to be no more. */
export function remove<T>(path: string): Promise<T> {
  return send('DELETE', path, null)
}

async function send<T>(method: string, path: string, body: unknown): Promise<T> {
  const once = (): Promise<T> => {
    const headers = { 'content-type': 'application/json', 'x-csrf-token': proof.token }
    return answer(path, { method, headers, body: JSON.stringify(body) })
  }
  return once().catch(async (error: unknown) => {
    if (error instanceof Refused && error.status === 403 && (await proof.renewed())) return once()
    throw error
  })
}

const LOGIN = '/api/login'

async function answer<T>(path: string, request: RequestInit): Promise<T> {
  const answer = await fetch(path, request).catch((error: unknown) => {
    throw request.signal?.aborted ? error : new Refused(LOST)
  })
  const body: unknown = await answer.json().catch(() => null)
  if (answer.ok) return body as T
  if (answer.status === 401 && path !== LOGIN) proof.ended()
  const problem = (body as { problem?: string } | null)?.problem
  throw new Refused(problem ?? `The station answers with ${answer.status}.`, answer.status, body)
}

export const session = (): Promise<Session> => get('/api/session', {})
export const login = (name: string, password: string): Promise<Session> => post(LOGIN, { name, password })
export const logout = (): Promise<void> => post('/api/logout', null)
export const changePassword = (current: string, next: string): Promise<Session> =>
  post('/api/password', { current, new: next })

export function address(path: string, query: Record<string, string | number>): string {
  const text = new URLSearchParams(Object.entries(query).map(([name, value]) => [name, String(value)])).toString()
  return text ? `${path}?${text}` : path
}

export function trend(series: string, from: number, to: number, pixels: number, signal?: AbortSignal): Promise<Trend> {
  return get('/api/trend', { series, from, to, pixels }, signal)
}

export function events(from: number, to: number, most: number, signal?: AbortSignal): Promise<Happening[]> {
  return get('/api/events', { from, to, most }, signal)
}

export function rise(series: string, from: number, to: number, volume_m3: number | null): Promise<Rise> {
  return get('/api/rise', { series, from, to, ...(volume_m3 === null ? {} : { volume_m3 }) })
}

export function blocks(gauge: string): Promise<Block[]> {
  return get(`/api/gauges/${encodeURIComponent(gauge)}/blocks`, {})
}

export const alarms = (signal?: AbortSignal): Promise<Alarm[]> => get('/api/alarms', {}, signal)
export const webhooks = (signal?: AbortSignal): Promise<Webhook[]> => get('/api/webhooks', {}, signal)

export function alarmHistory(from: number, to: number, most: number, signal?: AbortSignal): Promise<AlarmEvent[]> {
  return get('/api/alarms/history', { from, to, most }, signal)
}

const alarmPath = (name: string, what: string): string => `/api/alarms/${encodeURIComponent(name)}/${what}`

export function acknowledge(name: string, occurrence: number): Promise<Alarm> {
  return post(alarmPath(name, 'acknowledge'), { occurrence })
}

/** Each is acknowledged or refused for itself. */
export function acknowledgeAll(
  alarms: { name: string; occurrence: number }[],
): Promise<{ acknowledged: string[]; refused: { name: string; problem: string }[] }> {
  return post('/api/alarms/acknowledge', { alarms })
}

export function outOfService(name: string, reason: string, minutes: number | null): Promise<Alarm> {
  return post(alarmPath(name, 'out-of-service'), { reason, minutes })
}

export const returnToService = (name: string): Promise<Alarm> => post(alarmPath(name, 'return-to-service'), {})

export function exportAddress(series: string[], from: number, to: number): string {
  // Each by itself: a name may have a comma in it.
  const query = [['from', String(from)], ['to', String(to)], ...series.map((name) => ['series', name])]
  return `/api/export.csv?${new URLSearchParams(query).toString()}`
}
