// Events: logins, changes on the bus, alarms, commands, notes.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { fetchEvents } from '../api/calls.ts'
import type { StationEvent } from '../api/types.ts'
import { Choice, SearchField } from '../components/fields.tsx'
import { type Column, LogTable, Time, useLog } from '../components/log.tsx'
import { NoteDialog } from '../components/note-dialog.tsx'
import { EVENT_KINDS } from '../lib/labels.ts'
import { live } from '../live.ts'
import { gaugePath, Link } from '../router.tsx'
import { hasRole, useSession } from '../session.ts'

/** The newest event may be ahead of the clock of the browser. */
const AHEAD_MS = 60_000

const KINDS: [string, string][] = [['', 'all kinds'], ...Object.entries(EVENT_KINDS)]

const COLUMNS: Column<StationEvent>[] = [
  { title: 'Time', class: 'time', cell: ({ at_ms }) => <Time at={at_ms} /> },
  { title: 'Kind', cell: ({ kind }) => <span class={`kind ${kind}`}>{EVENT_KINDS[kind]}</span> },
  { title: 'Gauge', cell: ({ gauge }) => gauge && <Link to={gaugePath(gauge)}>{gauge}</Link> },
  { title: 'Event', cell: ({ text }) => text },
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
    <section class="panel events" aria-label="Events">
      <div class="bar">
        <h1>Events</h1>
        <Choice label="Kind" value={kind} options={KINDS} onChange={setKind} />
        <SearchField label="Search events" value={text} onInput={setText} />
        {mayNote && (
          <button type="button" onClick={() => setNoting(true)}>
            Make a note
          </button>
        )}
      </div>
      <LogTable
        caption="Events, the latest first"
        columns={COLUMNS}
        log={log}
        shown={shown}
        keyOf={({ at_ms, text }) => `${at_ms} ${text}`}
        empty={{ none: 'No events yet.', filtered: 'No event matches.', isFiltered: log.entries.length > 0 }}
      />
      {isNoting && <NoteDialog at={null} made={() => setNotes(notes + 1)} close={() => setNoting(false)} />}
    </section>
  )
}
