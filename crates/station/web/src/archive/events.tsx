// Events of all stations.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { getFrom } from '../api/request.ts'
import type { EventKind } from '../api/types.ts'
import { Choice, SearchField, sameText } from '../components/fields.tsx'
import { type Column, LogTable, Time, useLog } from '../components/log.tsx'
import { Unbroken } from '../components/unbroken.tsx'
import { readable } from '../lib/format.ts'
import { matchesWords } from '../lib/search.ts'
import { t } from '../texts/texts.ts'
import { live, useArchive } from './live.ts'
import { stationsOf } from './plant.ts'
import type { ArchivedEvent } from './types.ts'

/** The clock of a station may be ahead. */
const AHEAD_MS = 3_600_000

const columns = (): Column<ArchivedEvent>[] => [
  { title: t.common.time, class: 'time', cell: ({ at_ms }) => <Time at={at_ms} /> },
  { title: t.archive.station, cell: ({ station }) => station },
  {
    title: t.events.kind,
    cell: ({ kind }) => <span class={`kind ${kind}`}>{t.eventKinds[kind as EventKind] ?? kind}</span>,
  },
  { title: t.common.gauge, cell: ({ gauge }) => gauge },
  {
    title: t.events.event,
    cell: ({ kind, text }) => (
      <span lang={kind === 'note' ? undefined : 'en'}>
        <Unbroken text={readable(text)} />
      </span>
    ),
  },
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
    <section class="panel events" aria-label={t.pages['/events']}>
      <div class="bar">
        <h1>{t.pages['/events']}</h1>
        <Choice
          label={t.archive.station}
          value={station}
          options={[['', t.archive.allStations], ...sameText(names)]}
          onChange={setStation}
        />
        <SearchField label={t.events.search} value={text} onInput={setText} />
      </div>
      <LogTable
        caption={t.events.caption}
        columns={columns()}
        log={log}
        shown={shown}
        keyOf={({ station, at_ms, text }) => `${station} ${at_ms} ${text}`}
        empty={{ none: t.events.none, filtered: t.events.noMatch, isFiltered: log.entries.length > 0 }}
      />
    </section>
  )
}
