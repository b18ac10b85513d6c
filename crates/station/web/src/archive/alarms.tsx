// The alarms of all stations that are not normal, the most urgent first.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { postTo } from '../api/request.ts'
import { AlarmStateMark, PriorityMark } from '../components/alarm-marks.tsx'
import { SearchField } from '../components/fields.tsx'
import { errorText } from '../components/hooks.ts'
import { type Column, LogTable, Time } from '../components/log.tsx'
import { matchesWords } from '../lib/search.ts'
import { hasRole, useSession } from '../session.ts'
import { useArchive } from './live.ts'
import { alarmsOf } from './plant.ts'
import type { ActiveAlarm } from './types.ts'

const COLUMNS: Column<ActiveAlarm>[] = [
  { title: 'Priority', cell: ({ priority }) => <PriorityMark priority={priority} /> },
  { title: 'State', cell: ({ state }) => <AlarmStateMark state={state} /> },
  { title: 'Station', cell: ({ station }) => station },
  { title: 'Alarm', cell: ({ alarm }) => alarm },
  { title: 'Since', class: 'time', cell: ({ at_ms }) => <Time at={at_ms} /> },
  { title: 'What happened', cell: ({ text, user }) => (user ? `${text} (${user})` : text) },
]

const isWaiting = ({ state }: ActiveAlarm): boolean => state === 'unacknowledged' || state === 'returned'

const acknowledgePath = ({ station, alarm }: ActiveAlarm): string =>
  `/api/stations/${encodeURIComponent(station)}/alarms/${encodeURIComponent(alarm)}/acknowledge`

export function Alarms(): JSX.Element {
  const [text, setText] = useState('')
  const state = useArchive()
  const all = alarmsOf(state)
  const [problem, setProblem] = useState<string | null>(null)
  const mayAcknowledge = hasRole(useSession(), 'operator')
  const acknowledge = async (alarm: ActiveAlarm): Promise<void> => {
    try {
      await postTo(acknowledgePath(alarm), { occurrence: alarm.occurrence })
      setProblem(null)
    } catch (error) {
      setProblem(errorText(error))
    }
  }
  const column: Column<ActiveAlarm> = {
    title: 'Action',
    cell: (alarm) =>
      isWaiting(alarm) && (
        <button type="button" onClick={() => void acknowledge(alarm)}>
          Acknowledge
        </button>
      ),
  }
  const shown = all.filter(({ plant, station, alarm, text: what }) => matchesWords([plant, station, alarm, what], text))
  return (
    <section class="panel" aria-label="Alarms">
      <div class="bar">
        <h1>Alarms</h1>
        <SearchField label="Search alarms" value={text} onInput={setText} />
      </div>
      {!mayAcknowledge && <p class="muted">An operator acknowledges alarms here, or at their station.</p>}
      {problem && (
        <p class="error" role="alert">
          {problem}
        </p>
      )}
      <LogTable
        caption="Alarms, the most urgent first"
        columns={mayAcknowledge ? [...COLUMNS, column] : COLUMNS}
        log={{ entries: all, error: null, isLoaded: true, showOlder: null }}
        shown={shown}
        keyOf={({ station, alarm }) => `${station}/${alarm}`}
        empty={{ none: 'All alarms are normal.', filtered: 'No alarm matches.', isFiltered: all.length > 0 }}
      />
      {state.not_listed > 0 && <p class="muted">{state.not_listed} more alarms are not listed.</p>}
    </section>
  )
}
