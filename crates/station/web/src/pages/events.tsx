// Events: logins, changes on the bus, alarms, commands, notes.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { fetchEvents } from '../api/calls.ts'
import type { StationEvent } from '../api/types.ts'
import { Choice, SearchField } from '../components/fields.tsx'
import { type Column, LogTable, Time, useLog } from '../components/log.tsx'
import { NoteDialog } from '../components/note-dialog.tsx'
import { Unbroken } from '../components/unbroken.tsx'
import { readable } from '../lib/format.ts'
import { live } from '../live.ts'
import { gaugePath, Link } from '../router.tsx'
import { hasRole, useSession } from '../session.ts'
import { t } from '../texts/texts.ts'

/** The newest event may be ahead of the clock of the browser. */
const AHEAD_MS = 60_000

const kinds = (): [string, string][] => [['', t.events.allKinds], ...Object.entries(t.eventKinds)]

const columns = (): Column<StationEvent>[] => [
  { title: t.common.time, class: 'time', cell: ({ at_ms }) => <Time at={at_ms} /> },
  { title: t.events.kind, cell: ({ kind }) => <span class={`kind ${kind}`}>{t.eventKinds[kind] ?? kind}</span> },
  { title: t.common.gauge, cell: ({ gauge }) => gauge && <Link to={gaugePath(gauge)}>{gauge}</Link> },
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
  const [kind, setKind] = useState('')
  const [text, setText] = useState('')
  const [notes, setNotes] = useState(0)
  const [isNoting, setNoting] = useState(false)
  const mayNote = hasRole(useSession(), 'operator')
  const log = useLog(`events ${notes}`, (most, signal) =>
    fetchEvents(0, Math.ceil(live().now) + AHEAD_MS, most, signal),
  )
  const shown = log.entries.filter(
    (event) =>
      (!kind || event.kind === kind) && `${event.gauge ?? ''} ${event.text}`.toLowerCase().includes(text.toLowerCase()),
  )
  return (
    <section class="panel events" aria-label={t.pages['/events']}>
      <div class="bar">
        <h1>{t.pages['/events']}</h1>
        <Choice label={t.events.kind} value={kind} options={kinds()} onChange={setKind} />
        <SearchField label={t.events.search} value={text} onInput={setText} />
        {mayNote && (
          <button type="button" onClick={() => setNoting(true)}>
            {t.note.make}
          </button>
        )}
      </div>
      <LogTable
        caption={t.events.caption}
        columns={columns()}
        log={log}
        shown={shown}
        keyOf={({ at_ms, text }) => `${at_ms} ${text}`}
        empty={{ none: t.events.none, filtered: t.events.noMatch, isFiltered: log.entries.length > 0 }}
      />
      {isNoting && <NoteDialog at={null} made={() => setNotes(notes + 1)} close={() => setNoting(false)} />}
    </section>
  )
}
