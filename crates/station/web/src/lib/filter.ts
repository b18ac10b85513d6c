// The filter of the overview. The address of the page holds it, so that it can be bookmarked.

import type { Gauge, GaugeLabels } from '../api/types.ts'
import { matchesWords } from './search.ts'

/** Which gauges are shown; an empty string shows all. */
export interface Filter {
  /** Words that are searched in name, segment, device and labels. */
  text: string
  group: string
  tag: string
  location: string
  state: StateFilter
}

export type StateFilter = '' | 'problems' | 'alarms' | 'fault' | 'no-data' | 'calibration-overdue'

/** The states in the order of the choice. */
export const STATE_FILTERS: readonly StateFilter[] = [
  '',
  'problems',
  'alarms',
  'fault',
  'no-data',
  'calibration-overdue',
]

export const stateFilter = (text: string): StateFilter => STATE_FILTERS.find((state) => state === text) ?? ''

/** The parameters of the address. */
const KEYS = { text: 'q', group: 'group', tag: 'tag', location: 'location', state: 'state' } as const

export const NO_LABELS: GaugeLabels = {
  group: null,
  tags: [],
  location: null,
  calibrated: null,
  calibration_due: null,
}

/** The filter in an address. An unknown state is none. */
export function filterOf(query: URLSearchParams): Filter {
  const of = (key: string): string => query.get(key) ?? ''
  return {
    text: of(KEYS.text),
    group: of(KEYS.group),
    tag: of(KEYS.tag),
    location: of(KEYS.location),
    state: stateFilter(of(KEYS.state)),
  }
}

/** A state in the address that does not exist, and so selects nothing; `null` if there is none. */
export function unknownState(query: URLSearchParams): string | null {
  const text = query.get(KEYS.state) ?? ''
  return text !== '' && stateFilter(text) === '' ? text : null
}

/** The address of a filter. */
export function filterQuery(filter: Filter): URLSearchParams {
  const given = Object.entries(KEYS).filter(([name]) => filter[name as keyof Filter] !== '')
  return new URLSearchParams(given.map(([name, key]) => [key, filter[name as keyof Filter]]))
}

export const isFiltered = (filter: Filter): boolean => Object.values(filter).some((value) => value !== '')

/** Whether a filter needs the labels of the gauges. */
export const needsLabels = ({ group, tag, location, state }: Filter): boolean =>
  group + tag + location !== '' || state === 'calibration-overdue'

/** What the filter of a state asks about a gauge. */
export interface GaugeState {
  isAlarmed: boolean
  isFault: boolean
  isStale: boolean
  /** Today as `2026-01-31`. */
  today: string
}

/** Whether the calibration of a gauge is no longer valid. */
export const isOverdue = ({ calibration_due: due }: GaugeLabels, today: string): boolean => due !== null && due < today

export function passes(filter: Filter, gauge: Gauge, labels: GaugeLabels, now: GaugeState): boolean {
  const texts = [gauge.name, gauge.segment, gauge.device, labels.group ?? '', labels.location ?? '', ...labels.tags]
  const hasLabels =
    (filter.group === '' || labels.group === filter.group) &&
    (filter.tag === '' || labels.tags.includes(filter.tag)) &&
    (filter.location === '' || labels.location === filter.location)
  return hasLabels && matchesWords(texts, filter.text) && hasState(filter.state, gauge, labels, now)
}

function hasState(state: StateFilter, gauge: Gauge, labels: GaugeLabels, now: GaugeState): boolean {
  if (state === 'problems') return now.isAlarmed || now.isStale || gauge.state !== 'data-exchange'
  if (state === 'alarms') return now.isAlarmed
  if (state === 'fault') return now.isFault
  if (state === 'no-data') return now.isStale
  return state === '' || isOverdue(labels, now.today)
}

/** All values of a label, sorted with numbers by their value, with one that is chosen and that no gauge has. */
export function choices(values: readonly (string | null)[], chosen: string): string[] {
  const all = new Set(values.filter((value) => value !== null))
  if (chosen !== '') all.add(chosen)
  return [...all].sort((one, other) => one.localeCompare(other, 'en', { numeric: true }))
}
