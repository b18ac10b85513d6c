// Active and unacknowledged alarms, the most urgent first, in groups by the volumes of the plant.

import './groups.css'
import type { ComponentChildren, JSX, TargetedEvent } from 'preact'
import { useLayoutEffect, useMemo, useRef, useState } from 'preact/hooks'
import type { Alarm } from '../../api/types.ts'
import { AlarmSummaryText } from '../../components/alarm-marks.tsx'
import { SoundSwitch } from '../../components/alarm-sound.tsx'
import { Choice, SearchField } from '../../components/fields.tsx'
import { labelsOf, useDirectory } from '../../components/gauge-filter.tsx'
import { usePlant } from '../../components/plant-picture.tsx'
import {
  type AlarmFilter,
  type AlarmGroup,
  alarmGroups,
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
  SCREEN_ALARMS,
  summaryOf,
  valuesOf,
} from '../../lib/alarm-groups.ts'
import { afterHead, held, inOrder, ORDERS, type Order } from '../../lib/alarm-order.ts'
import { countsText, isUnacknowledged, PRIORITIES } from '../../lib/alarms.ts'
import { day } from '../../lib/format.ts'
import { volumesOfAlarms } from '../../lib/picture.ts'
import { useLive, useSnapshot } from '../../live.ts'
import { hasRole, useSession } from '../../session.ts'
import { t } from '../../texts/texts.ts'
import { acknowledgeThese } from './acknowledge-dialog.tsx'
import type { RunAction } from './item.tsx'
import { AlarmHead, AlarmLine } from './line.tsx'
import type { Suppress } from './suppress-dialog.tsx'

/** The order of the list is kept for this long after the last movement of the pointer or key in it. */
const HOLD_MS = 5_000

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

/** A set of names, and a function that adds and removes one. */
function useNames(): [ReadonlySet<string>, (name: string, isIn: boolean) => void] {
  const [names, setNames] = useState<ReadonlySet<string>>(new Set())
  const change = (name: string, isIn: boolean): void =>
    setNames((before) => {
      const made = new Set(before)
      if (isIn) made.add(name)
      else made.delete(name)
      return made
    })
  return [names, change]
}

/** A tick is about an alarm that the user sees: the same alarm has none when it is raised again. */
const occurrenceOf = ({ name, occurrence }: Alarm): string => `${occurrence} ${name}`

const inGivenOrder = (): number => 0

export function ActiveAlarmList({ all, error, run, suppress, ask, edit }: Props): JSX.Element {
  const { alarms } = useSnapshot()
  const { now, connected } = useLive()
  const { directory } = useDirectory()
  const volumeOf = useVolumeOf()
  const presentValue = useMemo(() => valuesOf(all), [all])
  const [filter, setFilter] = useState(NO_FILTER)
  const [order, setOrder] = useState<Order>('urgency')
  const [ticked, tick] = useNames()
  const [openLines, openLine] = useNames()
  const { list, waiting, isHeld, hold, release } = useHeldOrder(inOrder(alarms.alarms, order))
  const present = new Set(alarms.alarms.map(({ name }) => name))
  const groups = alarmGroups(list, (alarm) => placeOf(alarm, volumeOf), inGivenOrder)
  const [opened, open] = useOpenGroups(groups, list.length <= SCREEN_ALARMS)
  const passes = (alarm: Alarm, place: Place): boolean =>
    passesFilter(alarm, filter, place, alarm.gauge && labelsOf(directory, alarm.gauge).location)
  const shown =
    order === 'urgency'
      ? passing(groups, passes, isHeld ? inGivenOrder : undefined)
      : list
          .filter((alarm) => passes(alarm, placeOf(alarm, volumeOf)))
          .map((alarm) => ({ key: alarm.name, place: placeOf(alarm, volumeOf), alarms: [alarm], first: null }))
  const isOpen = (group: AlarmGroup): boolean => !hasHeading(group) || (opened.get(group.key)?.open ?? true)
  const acknowledgeAll = (unacknowledged: Alarm[]): void =>
    mustAsk(unacknowledged, shown, isOpen) ? ask(unacknowledged) : run(() => acknowledgeThese(unacknowledged))
  const passed = shown.flatMap(({ alarms }) => alarms).filter(({ name }) => present.has(name))
  const lines = useRef<HTMLUListElement>(null)
  const pressed = useFocusOnNext(lines)
  const work = (event: TargetedEvent<HTMLUListElement>): void => {
    hold()
    pressed(event)
  }
  const sortBy = (next: Order): void => {
    release()
    setOrder(next)
  }
  const today = day(now)
  return (
    <section class="panel active-alarms" aria-label={t.alarms.active}>
      <Head
        list={passed}
        ticked={passed.filter((alarm) => ticked.has(occurrenceOf(alarm)))}
        acknowledge={acknowledgeAll}
        acknowledgeTicked={(chosen) => {
          for (const alarm of chosen) tick(occurrenceOf(alarm), false)
          run(() => acknowledgeThese(chosen))
        }}
        suppress={suppress}
      >
        <FilterBar filter={filter} setFilter={setFilter} shown={passed.length} all={alarms.alarms.length} />
        <Choice
          label={t.alarms.order}
          value={order}
          options={ORDERS.map((one) => [one, t.alarms.orders[one]] as const)}
          onChange={(value) => sortBy(ORDERS.find((one) => one === value) ?? 'urgency')}
        />
        <SoundSwitch />
        {waiting > 0 && (
          <button type="button" onClick={release}>
            {t.alarms.newOnes(waiting)}
          </button>
        )}
      </Head>
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
      {list.length > 0 && shown.length === 0 && <p class="muted">{t.alarms.noMatch}</p>}
      {shown.length > 0 && <AlarmHead sorting={{ order, press: (column) => sortBy(afterHead(order, column)) }} />}
      <ul
        class="alarm-list"
        ref={lines}
        onPointerMove={hold}
        onPointerLeave={({ pointerType }) => pointerType === 'mouse' && release()}
        onKeyDown={hold}
        onClick={work}
      >
        {shown.flatMap((group) => {
          const items = group.alarms.map((alarm) => (
            <AlarmLine
              alarm={alarm}
              value={presentValue(alarm)}
              isGone={!present.has(alarm.name)}
              isTicked={ticked.has(occurrenceOf(alarm))}
              isOpen={openLines.has(alarm.name)}
              connected={connected}
              now={now}
              today={today}
              run={run}
              suppress={suppress}
              edit={edit}
              tick={(isTicked) => tick(occurrenceOf(alarm), isTicked)}
              open={(isOpen) => openLine(alarm.name, isOpen)}
              key={alarm.name}
            />
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

interface Held {
  list: Alarm[]
  /** How many alarms have come since then. */
  waiting: number
  isHeld: boolean
  hold: () => void
  release: () => void
}

/** The list; its order stays while the user works in it, so that nothing moves under the pointer. A snapshot draws it again when that is over. */
function useHeldOrder(sorted: Alarm[]): Held {
  const kept = useRef<{ until: number; list: Alarm[] }>({ until: 0, list: [] })
  const [, setReleases] = useState(0)
  const isHeld = performance.now() < kept.current.until && kept.current.list.length > 0
  const { list, waiting } = isHeld ? held(kept.current.list, sorted) : { list: sorted, waiting: 0 }
  kept.current.list = list
  return {
    list,
    waiting,
    isHeld,
    hold: () => {
      kept.current.until = performance.now() + HOLD_MS
    },
    release: () => {
      kept.current.until = 0
      setReleases((count) => count + 1)
    },
  }
}

/** When the pressed button of an alarm is gone because the alarm is acknowledged, the next such button has the focus. */
function useFocusOnNext(list: { current: HTMLUListElement | null }): (event: TargetedEvent<HTMLUListElement>) => void {
  const pressed = useRef<{ line: Element; button: Element } | null>(null)
  useLayoutEffect(() => {
    const last = pressed.current
    if (!last || last.button.isConnected) return
    pressed.current = null
    // The user may have gone elsewhere meanwhile.
    if (document.activeElement !== document.body) return
    const buttons = [...(list.current?.querySelectorAll<HTMLElement>('button.acknowledge') ?? [])]
    const isAfter = (one: Element): boolean =>
      (last.line.compareDocumentPosition(one) & Node.DOCUMENT_POSITION_FOLLOWING) !== 0
    const next = (last.line.isConnected && buttons.find(isAfter)) || buttons[0]
    next?.focus()
  })
  return ({ target }) => {
    const button = target instanceof Element ? target.closest('button.acknowledge') : null
    const line = button?.closest('.alarm-line')
    if (button && line) pressed.current = { line, button }
  }
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
  /** The ticked ones of them. */
  ticked: Alarm[]
  acknowledge: (alarms: Alarm[]) => void
  acknowledgeTicked: (alarms: Alarm[]) => void
  suppress: (suppress: Suppress) => void
  children: ComponentChildren
}

/** Each button keeps its place: what has nothing to do is disabled. */
function Head({ list, ticked, acknowledge, acknowledgeTicked, suppress, children }: HeadProps): JSX.Element {
  const mayAcknowledge = hasRole(useSession(), 'operator')
  const unacknowledged = list.filter(isUnacknowledged)
  const chosen = ticked.filter(isUnacknowledged)
  return (
    <div class="bar">
      <h1>{t.pages['/alarms']}</h1>
      {mayAcknowledge && (
        <>
          <button type="button" disabled={unacknowledged.length === 0} onClick={() => acknowledge(unacknowledged)}>
            {t.alarms.acknowledgeAll(unacknowledged.length)}
          </button>
          <button type="button" disabled={chosen.length === 0} onClick={() => acknowledgeTicked(chosen)}>
            {t.alarms.acknowledgeSelected(chosen.length)}
          </button>
          <button type="button" disabled={list.length === 0} onClick={() => suppress({ kind: 'shelve', alarms: list })}>
            {t.alarms.shelveAll(list.length)}
          </button>
          <button
            type="button"
            disabled={ticked.length === 0}
            onClick={() => suppress({ kind: 'shelve', alarms: ticked })}
          >
            {t.alarms.shelveSelected(ticked.length)}
          </button>
        </>
      )}
      {!mayAcknowledge && unacknowledged.length > 0 && <span class="muted">{t.alarms.operatorCan}</span>}
      {children}
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
    <>
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
    </>
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
