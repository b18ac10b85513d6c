// The alarms of all stations that are not normal, the most urgent first.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { postTo } from '../api/request.ts'
import { AlarmStateMark, PriorityMark } from '../components/alarm-marks.tsx'
import { SearchField } from '../components/fields.tsx'
import { errorText } from '../components/hooks.ts'
import { type Column, LogTable, Time } from '../components/log.tsx'
import { Unbroken } from '../components/unbroken.tsx'
import { isActive } from '../lib/alarms.ts'
import { readable } from '../lib/format.ts'
import { matchesWords } from '../lib/search.ts'
import { hasRole, useSession } from '../session.ts'
import { t } from '../texts/texts.ts'
import { useArchive } from './live.ts'
import { alarmsOf } from './plant.ts'
import type { ActiveAlarm } from './types.ts'

const columns = (): Column<ActiveAlarm>[] => [
  {
    title: t.common.priority,
    cell: ({ priority, state }) => <PriorityMark priority={priority} active={isActive({ state })} />,
  },
  { title: t.common.state, cell: ({ state }) => <AlarmStateMark state={state} /> },
  { title: t.archive.station, cell: ({ station }) => station },
  { title: t.common.alarm, cell: ({ alarm }) => <Unbroken text={alarm} /> },
  { title: t.archive.since, class: 'time', cell: ({ at_ms }) => <Time at={at_ms} /> },
  {
    title: t.archive.happened,
    cell: ({ text, user }) => <Unbroken text={user ? `${readable(text)} (${user})` : readable(text)} />,
  },
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
    title: t.archive.action,
    cell: (alarm) =>
      isWaiting(alarm) && (
        <button type="button" onClick={() => void acknowledge(alarm)}>
          {t.alarms.acknowledge}
        </button>
      ),
  }
  const shown = all.filter(({ plant, station, alarm, text: what }) => matchesWords([plant, station, alarm, what], text))
  return (
    <section class="panel" aria-label={t.pages['/alarms']}>
      <div class="bar">
        <h1>{t.pages['/alarms']}</h1>
        <SearchField label={t.alarms.search} value={text} onInput={setText} />
      </div>
      {!mayAcknowledge && <p class="muted">{t.archive.operator}</p>}
      {problem && (
        <p class="error" role="alert">
          {problem}
        </p>
      )}
      <LogTable
        caption={t.archive.caption}
        columns={mayAcknowledge ? [...columns(), column] : columns()}
        log={{ entries: all, query: { value: all, error: null, again: () => {} }, showOlder: null }}
        shown={shown}
        keyOf={({ station, alarm }) => `${station}/${alarm}`}
        empty={{ none: t.archive.allNormal, filtered: t.alarms.noMatch, isFiltered: all.length > 0 }}
      />
      {state.not_listed > 0 && <p class="muted">{t.archive.notListed(state.not_listed)}</p>}
    </section>
  )
}
