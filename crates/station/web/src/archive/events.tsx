// Events of all stations.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { getFrom } from '../api/request.ts'
import type { EventKind } from '../api/types.ts'
import { Choice, SearchField, sameText } from '../components/fields.tsx'
import { type Column, LogTable, Time, useLog } from '../components/log.tsx'
import { EVENT_KINDS } from '../lib/labels.ts'
import { matchesWords } from '../lib/search.ts'
import { live, useArchive } from './live.ts'
import { stationsOf } from './plant.ts'
import type { ArchivedEvent } from './types.ts'

/** The clock of a station may be ahead. */
const AHEAD_MS = 3_600_000

const COLUMNS: Column<ArchivedEvent>[] = [
  { title: 'Time', class: 'time', cell: ({ at_ms }) => <Time at={at_ms} /> },
  { title: 'Station', cell: ({ station }) => station },
  { title: 'Kind', cell: ({ kind }) => <span class={`kind ${kind}`}>{EVENT_KINDS[kind as EventKind] ?? kind}</span> },
  { title: 'Gauge', cell: ({ gauge }) => gauge },
  { title: 'Event', cell: ({ text }) => text },
]

export function Events(): JSX.Element {
  const [station, setStation] = useState('')
  const [text, setText] = useState('')
  const names = stationsOf(useArchive()).map(({ name }) => name)
  const log = useLog(`events ${station}`, (most, signal) => {
    const query = new URLSearchParams({ from: '0', to: String(live().now + AHEAD_MS), limit: String(most) })
    if (station) query.set('station', station)
    return getFrom<ArchivedEvent[]>(`/api/events?${query}`, signal)
  })
  const shown = log.entries.filter((event) => matchesWords([event.station, event.gauge ?? '', event.text], text))
  return (
    <section class="panel events" aria-label="Events">
      <div class="bar">
        <h1>Events</h1>
        <Choice
          label="Station"
          value={station}
          options={[['', 'all stations'], ...sameText(names)]}
          onChange={setStation}
        />
        <SearchField label="Search events" value={text} onInput={setText} />
      </div>
      <LogTable
        caption="Events, the latest first"
        columns={COLUMNS}
        log={log}
        shown={shown}
        keyOf={({ station, at_ms, text }) => `${station} ${at_ms} ${text}`}
        empty={{ none: 'No events yet.', filtered: 'No event matches.', isFiltered: log.entries.length > 0 }}
      />
    </section>
  )
}
