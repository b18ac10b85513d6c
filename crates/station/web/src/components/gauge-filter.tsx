// The filter of gauges: its fields, and the gauges that pass.

import type { JSX } from 'preact'
import { fetchDirectory } from '../api/calls.ts'
import type { Alarm, Directory, Gauge, GaugeLabels } from '../api/types.ts'
import { isActive } from '../lib/alarms.ts'
import {
  choices,
  type Filter,
  filterOf,
  filterQuery,
  isOverdue,
  NO_LABELS,
  passes,
  STATE_FILTERS,
  stateFilter,
  unknownState,
} from '../lib/filter.ts'
import { day } from '../lib/format.ts'
import { currentQuality, isStale } from '../lib/stale.ts'
import { type Live, useLive, useSnapshot } from '../live.ts'
import { setQuery, useLocation } from '../router.tsx'
import { t } from '../texts/texts.ts'
import { Choice, SearchField } from './fields.tsx'
import { type Query, useQuery } from './hooks.ts'

/** The directory of the station; fetched again when it changes, after a restart, and after a connection that was lost while it came. */
export function useDirectory(): {
  directory: Directory | null
  error: string | null
  query: Pick<Query<Directory>, 'value' | 'error' | 'again'>
} {
  const { connected } = useLive()
  const { directory_revision: revision, station } = useSnapshot()
  const { value, error, again } = useQuery(`${station.started_ms} ${revision} ${connected}`, null, fetchDirectory)
  const shown = connected ? error : null
  const query = { value, error: shown === null ? null : t.overview.labelsFailed(shown), again }
  return { directory: value, error: shown, query }
}

export const labelsOf = (directory: Directory | null, gauge: string): GaugeLabels =>
  directory && Object.hasOwn(directory.gauges, gauge) ? (directory.gauges[gauge] ?? NO_LABELS) : NO_LABELS

/** The filter in the address, and a function that changes it. */
export function useFilter(): [Filter, (change: Partial<Filter>) => void] {
  const { query } = useLocation()
  const filter = filterOf(query)
  return [filter, (change) => setQuery(filterQuery({ ...filter, ...change }))]
}

/** Says that the address has a state that does not exist: it selects all gauges. Nothing otherwise. */
export function UnknownState(): JSX.Element | null {
  const state = unknownState(useLocation().query)
  if (state === null) return null
  return (
    <p class="muted unknown-state" role="status">
      {t.filter.unknownState(state, STATE_FILTERS.filter((known) => known !== '').join(', '))}
    </p>
  )
}

/** Whether a gauge passes the filter now. */
export function passesNow(filter: Filter, gauge: Gauge, labels: GaugeLabels, alarms: Alarm[], live: Live): boolean {
  const qualities = gauge.readings.map((reading) => currentQuality(gauge, reading, live.since))
  return passes(filter, gauge, labels, {
    isAlarmed: alarms.some(isActive),
    isFault: gauge.state === 'fault' || qualities.includes('fault'),
    // As the station has said: without a connection the last known gauges stay.
    isStale: isStale(gauge, 0),
    today: day(live.now),
  })
}

interface FieldsProps {
  filter: Filter
  change: (change: Partial<Filter>) => void
  directory: Directory | null
}

/** The fields of the filter. A label that no gauge has gets no field. */
export function FilterFields({ filter, change, directory }: FieldsProps): JSX.Element {
  const labels = Object.values(directory?.gauges ?? {})
  const groups = choices(
    labels.map(({ group }) => group),
    filter.group,
  )
  const tags = choices(
    labels.flatMap(({ tags }) => tags),
    filter.tag,
  )
  const locations = choices(
    labels.map(({ location }) => location),
    filter.location,
  )
  const field = (
    name: 'group' | 'tag' | 'location',
    label: string,
    all: string,
    values: string[],
  ): JSX.Element | null =>
    values.length > 0 ? (
      <Choice
        label={label}
        value={filter[name]}
        options={[['', all] as const, ...values.map((value) => [value, value] as const)]}
        onChange={(value) => change({ [name]: value })}
      />
    ) : null
  return (
    <>
      <SearchField
        label={t.filter.search}
        placeholder={t.filter.search}
        value={filter.text}
        onInput={(text) => change({ text })}
      />
      {field('group', t.filter.group, t.filter.allGroups, groups)}
      {field('tag', t.filter.tag, t.filter.allTags, tags)}
      {field('location', t.filter.location, t.filter.allLocations, locations)}
      <Choice
        label={t.common.state}
        value={filter.state}
        options={STATE_FILTERS.map((state) => [state, t.filter.states[state]] as const)}
        onChange={(value) => change({ state: stateFilter(value) })}
      />
    </>
  )
}

/** Says that a calibration is overdue; nothing otherwise. */
export function Overdue({ labels }: { labels: GaugeLabels }): JSX.Element | null {
  const { now } = useLive()
  if (!isOverdue(labels, day(now))) return null
  return <span class="overdue muted">{t.reading.overdue(labels.calibration_due ?? '')}</span>
}
