// The history of alarms.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { fetchAlarmHistory } from '../../api/calls.ts'
import type { AlarmEvent } from '../../api/types.ts'
import { PriorityMark } from '../../components/alarm-marks.tsx'
import { Choice, SearchField } from '../../components/fields.tsx'
import { type Column, LogTable, Time, useLog } from '../../components/log.tsx'
import { ALARM_CHANGES, matchesFilter, quantity } from '../../lib/alarms.ts'
import type { Unit } from '../../lib/units.ts'
import { live } from '../../live.ts'
import { useUnit } from '../../settings.ts'

/** The newest entry may be ahead of the clock of the browser. */
const AHEAD_MS = 60_000

const CHANGES: [string, string][] = [['', 'all changes'], ...Object.entries(ALARM_CHANGES)]

const columns = (unit: Unit): Column<AlarmEvent>[] => [
  { title: 'Time', class: 'time', cell: ({ at_ms }) => <Time at={at_ms} /> },
  { title: 'Priority', cell: ({ priority }) => <PriorityMark priority={priority} /> },
  { title: 'Change', cell: ({ change }) => ALARM_CHANGES[change] },
  {
    title: 'Alarm',
    cell: ({ alarm, text, value }) => (
      <>
        {alarm}
        {text && value === null && <span class="muted"> {text}</span>}
      </>
    ),
  },
  { title: 'User', class: 'short', cell: ({ user }) => user },
  { title: 'Value', class: 'short', cell: (event) => quantity(event.value, event.unit, unit) },
]

export function AlarmHistory(): JSX.Element {
  const unit = useUnit()
  const [change, setChange] = useState('')
  const [text, setText] = useState('')
  const log = useLog('history', (most, signal) => fetchAlarmHistory(0, Math.ceil(live().now) + AHEAD_MS, most, signal))
  const shown = log.entries.filter((event) => matchesFilter(event, change, text))
  return (
    <section class="panel alarm-history" aria-label="History">
      <div class="bar">
        <h2>History</h2>
        <Choice label="Change" value={change} options={CHANGES} onChange={setChange} />
        <SearchField label="Search the history" value={text} onInput={setText} />
      </div>
      <LogTable
        caption="Alarm history, the latest entry first"
        columns={columns(unit)}
        log={log}
        shown={shown}
        keyOf={({ at_ms, alarm, change }) => `${at_ms} ${alarm} ${change}`}
        empty={{ none: 'No entries yet.', filtered: 'No entry matches.', isFiltered: log.entries.length > 0 }}
      />
    </section>
  )
}
