// The history of alarms: of all times or a chosen one, sorted by a column, and as a CSV file.

import './history.css'
import type { JSX } from 'preact'
import { useRef, useState } from 'preact/hooks'
import { fetchAlarmHistory } from '../../api/calls.ts'
import type { AlarmEvent } from '../../api/types.ts'
import { PriorityMark } from '../../components/alarm-marks.tsx'
import { download } from '../../components/download.ts'
import { Choice, MomentField, SearchField } from '../../components/fields.tsx'
import { errorText } from '../../components/hooks.ts'
import { type Column, LogTable, type Sort, Time, useLog } from '../../components/log.tsx'
import { Unbroken } from '../../components/unbroken.tsx'
import {
  afterPress,
  HISTORY_COLUMNS,
  type HistoryColumn,
  type HistoryOrder,
  historyCsv,
  historyInOrder,
  historyTimes,
  isNewestFirst,
  NEWEST_FIRST,
} from '../../lib/alarm-history.ts'
import { matchesFilter, quantity } from '../../lib/alarms.ts'
import { day, grouped, readable } from '../../lib/format.ts'
import type { Unit } from '../../lib/units.ts'
import { live } from '../../live.ts'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'

/** The newest entry may be ahead of the clock of the browser. */
const AHEAD_MS = 60_000

/** The station sends at most this many entries. */
const MOST_ENTRIES = 10_000

/** A table that is filtered or sorted has all entries of its times. Many of them are fetched again only this often. */
const MANY_MS = 30_000
const MANY = 1_000

/** The number of rows of such a table at first, and with each press of `Show more entries`. */
const ROWS = 100

const DAY_MS = 86_400_000

const changes = (): [string, string][] => [['', t.alarms.allChanges], ...Object.entries(t.alarms.changes)]

const periods = (): [string, string][] => [
  ['', t.audit.allTimes],
  [`${DAY_MS}`, t.audit.lastDay],
  [`${7 * DAY_MS}`, t.audit.lastWeek],
  [`${30 * DAY_MS}`, t.audit.lastMonth],
  ['between', t.alarms.between],
]

const columns = (unit: Unit, sort: (column: HistoryColumn) => Sort): Column<AlarmEvent>[] => [
  { title: t.common.time, class: 'time', sort: sort('time'), cell: ({ at_ms }) => <Time at={at_ms} /> },
  {
    title: t.common.priority,
    sort: sort('priority'),
    cell: ({ priority }) => <PriorityMark priority={priority} active={false} />,
  },
  { title: t.alarms.change, sort: sort('change'), cell: ({ change }) => t.alarms.changes[change] ?? change },
  {
    title: t.common.alarm,
    sort: sort('alarm'),
    cell: ({ alarm, text, value }) => (
      <>
        <Unbroken text={alarm} />
        {text && value === null && (
          <span class="muted">
            {' '}
            <Unbroken text={readable(text)} />
          </span>
        )}
      </>
    ),
  },
  { title: t.common.user, class: 'short', sort: sort('user'), cell: ({ user }) => user },
  {
    title: t.common.value,
    class: 'short',
    sort: sort('value'),
    cell: (event) => <Unbroken text={quantity(event.value, event.unit, unit)} />,
  },
]

/** The orders for a page whose table has no heads. */
const orders = (): [string, string][] => {
  const { time, priority, alarm, user, value } = t.common
  const names = { time, priority, change: t.alarms.change, alarm, user, value }
  return [
    ['time', t.alarms.orders.newest],
    ['oldest', t.alarms.orders.oldest],
    ...HISTORY_COLUMNS.filter((column) => column !== 'time').map((column): [string, string] => [
      column,
      t.log.sort(names[column]),
    ]),
  ]
}

const orderOf = (chosen: string): HistoryOrder => {
  if (chosen === 'oldest') return { column: 'time', isDescending: false }
  const column = HISTORY_COLUMNS.find((one) => one === chosen) ?? 'time'
  return { column, isDescending: column === 'time' }
}

export function AlarmHistory(): JSX.Element {
  const unit = useUnit()
  const [change, setChange] = useState('')
  const [text, setText] = useState('')
  const [period, setPeriod] = useState('')
  const [typed, setTyped] = useState<[string, string]>(['', ''])
  const [order, setOrder] = useState(NEWEST_FIRST)
  const [rows, setRows] = useState(ROWS)
  const [error, setError] = useState<string | null>(null)
  const isFiltered = change !== '' || text !== '' || period !== ''
  /** The number of entries that the last request gave. */
  const count = useRef(0)
  const isWhole = isFiltered || !isNewestFirst(order)
  const fetch = (most: number, signal?: AbortSignal): Promise<AlarmEvent[]> => {
    const now = Math.ceil(live().now)
    const { from, to } = historyTimes(period, typed, now)
    return fetchAlarmHistory(from, Math.max(from, to ?? now + AHEAD_MS), most, signal)
  }
  const log = useLog(
    `history ${isWhole} ${period} ${typed.join()}`,
    (most, signal) => fetch(isWhole ? MOST_ENTRIES : most, signal),
    isWhole && count.current > MANY ? MANY_MS : undefined,
  )
  count.current = log.entries.length
  const chosen = (events: AlarmEvent[]): AlarmEvent[] =>
    historyInOrder(
      events.filter((event) => matchesFilter(event, change, text)),
      order,
    )
  const passed = chosen(log.entries)
  const more = isWhole ? passed.length - rows : 0
  const sort = (column: HistoryColumn): Sort => ({
    order: order.column !== column ? null : order.isDescending ? 'descending' : 'ascending',
    press: () => setOrder(afterPress(order, column)),
  })
  const save = (): void => {
    setError(null)
    fetch(MOST_ENTRIES).then(
      (events) =>
        download(new Blob([historyCsv(chosen(events))], { type: 'text/csv' }), `alarms ${day(live().now)}.csv`),
      (failed: unknown) => setError(errorText(failed)),
    )
  }
  return (
    <section class="panel alarm-history" aria-label={t.alarms.history}>
      <div class="bar">
        <h2>{t.alarms.history}</h2>
        <Choice label={t.common.time} value={period} options={periods()} onChange={setPeriod} />
        {period === 'between' && (
          <>
            <MomentField label={t.trends.from} value={typed[0]} onChange={(from) => setTyped([from, typed[1]])} />
            <MomentField label={t.trends.to} value={typed[1]} onChange={(to) => setTyped([typed[0], to])} />
          </>
        )}
        <Choice label={t.alarms.change} value={change} options={changes()} onChange={setChange} />
        <SearchField label={t.alarms.searchHistory} value={text} onInput={setText} />
        <span class="history-order">
          <Choice
            label={t.alarms.sortHistory}
            value={order.column === 'time' && !order.isDescending ? 'oldest' : order.column}
            options={orders()}
            onChange={(value) => setOrder(orderOf(value))}
          />
        </span>
        <button type="button" onClick={save}>
          {t.common.saveCsv}
        </button>
      </div>
      {error && (
        <p class="error" role="alert">
          {error}
        </p>
      )}
      {log.entries.length >= MOST_ENTRIES && (
        <p class="muted" role="status">
          {t.alarms.historyCut(grouped(MOST_ENTRIES))}
        </p>
      )}
      <LogTable
        caption={isNewestFirst(order) ? t.alarms.historyCaption : t.alarms.history}
        columns={columns(unit, sort)}
        log={isWhole ? { ...log, showOlder: null } : log}
        shown={more > 0 ? passed.slice(0, rows) : passed}
        keyOf={({ at_ms, alarm, change }) => `${at_ms} ${alarm} ${change}`}
        empty={{ none: t.common.noEntries, filtered: t.common.noEntryMatches, isFiltered }}
      />
      {more > 0 && (
        <button type="button" onClick={() => setRows(rows + ROWS)}>
          {t.log.more(more)}
        </button>
      )}
    </section>
  )
}
