// Active and unacknowledged alarms, the most urgent first, in groups by the volumes of the plant.

import './groups.css'
import type { ComponentChildren, JSX } from 'preact'
import { useMemo, useRef, useState } from 'preact/hooks'
import { acknowledge } from '../../api/calls.ts'
import type { Alarm } from '../../api/types.ts'
import { AlarmSummaryText } from '../../components/alarm-marks.tsx'
import { Choice, SearchField } from '../../components/fields.tsx'
import { labelsOf, useDirectory } from '../../components/gauge-filter.tsx'
import { usePlant } from '../../components/plant-picture.tsx'
import { Unbroken } from '../../components/unbroken.tsx'
import { useLanguage } from '../../language.ts'
import {
  type AlarmFilter,
  type AlarmGroup,
  alarmGroups,
  FEW_ALARMS,
  hasHeading,
  isFiltered,
  mustAsk,
  NO_FILTER,
  type Opened,
  openGroups,
  type Place,
  passesFilter,
  passing,
  placeOf,
  summaryOf,
  withValues,
} from '../../lib/alarm-groups.ts'
import { conditionText, countsText, isActive, isUnacknowledged, PRIORITIES, quantity } from '../../lib/alarms.ts'
import { age, readable } from '../../lib/format.ts'
import { volumesOfAlarms } from '../../lib/picture.ts'
import { useLive, useSnapshot } from '../../live.ts'
import { gaugePath, Link } from '../../router.tsx'
import { hasRole, useSession } from '../../session.ts'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'
import { acknowledgeThese } from './acknowledge-dialog.tsx'
import { AlarmItem, type RunAction, shortTime } from './item.tsx'
import { SettingsButton } from './settings-dialog.tsx'
import type { Suppress } from './suppress-dialog.tsx'

interface Props {
  /** All alarms, as they were fetched last. */
  all: Alarm[]
  /** Why the last action failed. */
  error: string | null
  run: RunAction
  suppress: (suppress: Suppress) => void
  /** Asks before it acknowledges. */
  ask: (alarms: Alarm[]) => void
  edit: (alarm: Alarm) => void
}

export function ActiveAlarmList({ all, error, run, suppress, ask, edit }: Props): JSX.Element {
  const { alarms } = useSnapshot()
  const { directory } = useDirectory()
  const volumeOf = useVolumeOf()
  const [filter, setFilter] = useState(NO_FILTER)
  const list = withValues(alarms.alarms, all)
  const groups = alarmGroups(list, (alarm) => placeOf(alarm, volumeOf))
  const [opened, open] = useOpenGroups(groups, list.length <= FEW_ALARMS)
  const shown = passing(groups, (alarm, place) =>
    passesFilter(alarm, filter, place, alarm.gauge && labelsOf(directory, alarm.gauge).location),
  )
  const isOpen = (group: AlarmGroup): boolean => !hasHeading(group) || (opened.get(group.key)?.open ?? true)
  const acknowledgeAll = (unacknowledged: Alarm[]): void =>
    mustAsk(unacknowledged, shown, isOpen) ? ask(unacknowledged) : run(() => acknowledgeThese(unacknowledged))
  const passed = shown.flatMap(({ alarms }) => alarms)
  return (
    <section class="panel" aria-label={t.alarms.active}>
      <Head list={passed} acknowledge={acknowledgeAll} suppress={suppress} />
      {/* A filter that hides alarms stays when the list becomes short. */}
      {(list.length > FEW_ALARMS || isFiltered(filter)) && (
        <FilterBar filter={filter} setFilter={setFilter} shown={passed.length} all={list.length} />
      )}
      {error && (
        <p class="error" role="alert">
          {error}
        </p>
      )}
      {alarms.problem && (
        <p class="error" role="alert">
          {t.alarms.mayBeWrong(alarms.problem)}
        </p>
      )}
      {list.length === 0 && <p class="muted no-alarms">{t.alarms.noneActive}</p>}
      {list.length > 0 && passed.length === 0 && <p class="muted">{t.alarms.noMatch}</p>}
      <ul class="alarm-list">
        {shown.flatMap((group) => {
          const items = group.alarms.map((alarm) => (
            <ActiveAlarm alarm={alarm} run={run} suppress={suppress} edit={edit} key={alarm.name} />
          ))
          return hasHeading(group) ? (
            <Group group={group} isOpen={isOpen(group)} open={open} key={group.key}>
              {items}
            </Group>
          ) : (
            items
          )
        })}
      </ul>
    </section>
  )
}

/** Tells in which volume of the plant an alarm is. */
function useVolumeOf(): (alarm: Alarm) => string | null {
  const { plant } = usePlant()
  const { gauges } = useSnapshot()
  const series = gauges.map(({ name, readings }) => [name, ...readings.map(({ series }) => series)].join()).join()
  // A snapshot arrives four times a second, and its gauges have the same series as before.
  return useMemo(() => (plant ? volumesOfAlarms(plant, gauges) : () => null), [plant, series])
}

/** Which groups are open, and a function by which the user opens and closes one. */
function useOpenGroups(
  groups: AlarmGroup[],
  isShort: boolean,
): [ReadonlyMap<string, Opened>, (key: string, open: boolean) => void] {
  const opened = useRef<ReadonlyMap<string, Opened>>(new Map())
  const [, setChanges] = useState(0)
  opened.current = openGroups(opened.current, groups, isShort)
  const open = (key: string, open: boolean): void => {
    opened.current = new Map(opened.current).set(key, { open, chosen: true })
    setChanges((count) => count + 1)
  }
  return [opened.current, open]
}

interface HeadProps {
  /** The alarms that pass the filter. */
  list: Alarm[]
  acknowledge: (alarms: Alarm[]) => void
  suppress: (suppress: Suppress) => void
}

function Head({ list, acknowledge, suppress }: HeadProps): JSX.Element {
  const mayAcknowledge = hasRole(useSession(), 'operator')
  const unacknowledged = list.filter(isUnacknowledged)
  return (
    <div class="bar">
      <h1>{t.pages['/alarms']}</h1>
      {mayAcknowledge && unacknowledged.length > 1 && (
        <button type="button" onClick={() => acknowledge(unacknowledged)}>
          {t.alarms.acknowledgeAll(unacknowledged.length)}
        </button>
      )}
      {mayAcknowledge && list.length > 1 && (
        <button type="button" onClick={() => suppress({ kind: 'shelve', alarms: list })}>
          {t.alarms.shelveAll(list.length)}
        </button>
      )}
      {!mayAcknowledge && unacknowledged.length > 0 && <span class="muted">{t.alarms.operatorCan}</span>}
    </div>
  )
}

interface FilterProps {
  filter: AlarmFilter
  setFilter: (filter: AlarmFilter) => void
  /** How many alarms pass, and how many there are. */
  shown: number
  all: number
}

function FilterBar({ filter, setFilter, shown, all }: FilterProps): JSX.Element {
  const priorities = [
    ['', t.alarms.allPriorities] as const,
    ...PRIORITIES.map((one) => [one, t.priorities[one]] as const),
  ]
  return (
    <div class="bar">
      <Choice
        label={t.common.priority}
        value={filter.priority}
        options={priorities}
        onChange={(value) => setFilter({ ...filter, priority: PRIORITIES.find((one) => one === value) ?? '' })}
      />
      <SearchField
        label={t.alarms.searchActive}
        value={filter.text}
        onInput={(text) => setFilter({ ...filter, text })}
      />
      <span class="muted" role="status">
        {isFiltered(filter) && t.alarms.shownOf(shown, all)}
      </span>
    </div>
  )
}

interface GroupProps {
  group: AlarmGroup
  isOpen: boolean
  open: (key: string, open: boolean) => void
  children: ComponentChildren
}

/** The alarms of one place below a heading that tells the most important about them. */
function Group({ group: { key, place, alarms, first }, isOpen, open, children }: GroupProps): JSX.Element {
  const summary = summaryOf(alarms)
  return (
    <li class="alarm-group" data-group={key}>
      <details
        open={isOpen}
        onToggle={({ currentTarget }) => currentTarget.open !== isOpen && open(key, currentTarget.open)}
      >
        <summary>
          <h2>{placeName(place)}</h2>{' '}
          {summary.active.length === 0 && (
            <span class="muted">{t.alarms.badge.cleared(countsText(summary.unacknowledgedCounts))}, </span>
          )}
          <AlarmSummaryText summary={summary} />
          {first && (
            <span class="muted">
              {' · '}
              <span class="first">{t.alarms.first(first.name)}</span>
            </span>
          )}
        </summary>
        {isOpen && <ul class="alarm-list">{children}</ul>}
      </details>
    </li>
  )
}

function placeName({ kind, name }: Place): string {
  if (kind === 'station') return t.eventKinds.station
  return kind === 'segment' ? t.overview.segment(name) : name
}

type ActiveProps = Pick<Props, 'run' | 'suppress' | 'edit'> & { alarm: Alarm }

function ActiveAlarm({ alarm, run, suppress, edit }: ActiveProps): JSX.Element {
  const session = useSession()
  const { name, occurrence, message } = alarm
  return (
    <AlarmItem
      alarm={alarm}
      buttons={
        <>
          {isUnacknowledged(alarm) && hasRole(session, 'operator') && (
            <button
              type="button"
              class={isActive(alarm) ? 'main acknowledge' : 'acknowledge'}
              onClick={() => run(() => acknowledge(name, occurrence))}
            >
              {t.alarms.acknowledge}
            </button>
          )}
          {hasRole(session, 'operator') && (
            <button type="button" class="shelve" onClick={() => suppress({ kind: 'shelve', alarms: [alarm] })}>
              {t.alarms.shelve}
            </button>
          )}
          {hasRole(session, 'engineer') && (
            <button
              type="button"
              class="take-out"
              onClick={() => suppress({ kind: 'out-of-service', alarms: [alarm] })}
            >
              {t.alarms.outOfService}
            </button>
          )}
          <SettingsButton alarm={alarm} open={edit} />
        </>
      }
    >
      <Values alarm={alarm} />
      <Times alarm={alarm} />
      {message && <p class="message">{message}</p>}
    </AlarmItem>
  )
}

/** The condition, the value when the alarm was raised, and the value now. */
function Values({ alarm }: { alarm: Alarm }): JSX.Element {
  const shown = useUnit()
  const { connected } = useLive()
  const { raised_value, value, limit, unit } = alarm
  if (raised_value === null || limit === null) return <Cause alarm={alarm} />
  const raised = t.alarms.whenRaised(conditionText(alarm, shown), quantity(raised_value, unit, shown))
  const at = connected ? t.alarms.nowAt : t.alarms.lastAt
  return (
    <p>
      <Unbroken text={value === null ? raised : at(raised, quantity(value, unit, shown))} />
    </p>
  )
}

/** The condition in the language of the user, and the words of the station, which are English: an English reader needs only these. */
function Cause({ alarm }: { alarm: Alarm }): JSX.Element {
  const shown = useUnit()
  const isEnglish = useLanguage() === 'en'
  const { text, state } = alarm
  const words = text && <Unbroken text={readable(text)} />
  return (
    <p>
      {/* The words say what is: of a cleared alarm, what was. */}
      {state === 'returned' && `${t.alarms.whenItWasRaised} `}
      {(!words || !isEnglish) && <Unbroken text={conditionText(alarm, shown)} />}
      {words && (
        <span lang="en" class={isEnglish ? undefined : 'muted'}>
          {!isEnglish && ' · '}
          {words}
        </span>
      )}
    </p>
  )
}

function Times({ alarm }: { alarm: Alarm }): JSX.Element {
  const { now } = useLive()
  const { raised_ms, acknowledged_by, acknowledged_ms, gauge, state, since_ms } = alarm
  const times = [
    raised_ms !== null && t.alarms.raised(shortTime(raised_ms, now), age(Math.max(0, now - raised_ms))),
    acknowledged_by &&
      acknowledged_ms !== null &&
      t.alarms.acknowledgedBy(acknowledged_by, shortTime(acknowledged_ms, now)),
    state === 'returned' && since_ms !== null && t.alarms.cleared(shortTime(since_ms, now)),
  ]
  return (
    <p class="muted">
      <Unbroken text={times.filter(Boolean).join(' · ')} />
      {gauge && (
        <>
          {' · '}
          <Link to={gaugePath(gauge)} class="gauge">
            {gauge}
          </Link>
        </>
      )}
    </p>
  )
}
