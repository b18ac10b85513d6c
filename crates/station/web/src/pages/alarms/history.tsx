// The history of alarms.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { fetchAlarmHistory } from '../../api/calls.ts'
import type { AlarmEvent } from '../../api/types.ts'
import { PriorityMark } from '../../components/alarm-marks.tsx'
import { Choice, SearchField } from '../../components/fields.tsx'
import { type Column, LogTable, Time, useLog } from '../../components/log.tsx'
import { Unbroken } from '../../components/unbroken.tsx'
import { matchesFilter, quantity } from '../../lib/alarms.ts'
import { readable } from '../../lib/format.ts'
import type { Unit } from '../../lib/units.ts'
import { live } from '../../live.ts'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'

/** The newest entry may be ahead of the clock of the browser. */
const AHEAD_MS = 60_000

const changes = (): [string, string][] => [['', t.alarms.allChanges], ...Object.entries(t.alarms.changes)]

const columns = (unit: Unit): Column<AlarmEvent>[] => [
  { title: t.common.time, class: 'time', cell: ({ at_ms }) => <Time at={at_ms} /> },
  { title: t.common.priority, cell: ({ priority }) => <PriorityMark priority={priority} active={false} /> },
  { title: t.alarms.change, cell: ({ change }) => t.alarms.changes[change] ?? change },
  {
    title: t.common.alarm,
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
  { title: t.common.user, class: 'short', cell: ({ user }) => user },
  {
    title: t.common.value,
    class: 'short',
    cell: (event) => <Unbroken text={quantity(event.value, event.unit, unit)} />,
  },
]

export function AlarmHistory(): JSX.Element {
  const unit = useUnit()
  const [change, setChange] = useState('')
  const [text, setText] = useState('')
  const log = useLog('history', (most, signal) => fetchAlarmHistory(0, Math.ceil(live().now) + AHEAD_MS, most, signal))
  const shown = log.entries.filter((event) => matchesFilter(event, change, text))
  return (
    <section class="panel alarm-history" aria-label={t.alarms.history}>
      <div class="bar">
        <h2>{t.alarms.history}</h2>
        <Choice label={t.alarms.change} value={change} options={changes()} onChange={setChange} />
        <SearchField label={t.alarms.searchHistory} value={text} onInput={setText} />
      </div>
      <LogTable
        caption={t.alarms.historyCaption}
        columns={columns(unit)}
        log={log}
        shown={shown}
        keyOf={({ at_ms, alarm, change }) => `${at_ms} ${alarm} ${change}`}
        empty={{ none: t.common.noEntries, filtered: t.common.noEntryMatches, isFiltered: log.entries.length > 0 }}
      />
    </section>
  )
}
