// What happened, the latest first.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { events, type EventKind } from '../api.ts'
import { live } from '../live.ts'
import { useAsked } from '../parts/use.ts'
import { clock, day } from '../pure/format.ts'
import { KINDS } from '../pure/words.ts'
import { gaugePath, Link } from '../router.tsx'

const AGAIN_MS = 3_000
const PAGE = 100

export function Events(): JSX.Element {
  const [most, setMost] = useState(PAGE)
  const [kind, setKind] = useState<EventKind | ''>('')
  const [text, setText] = useState('')
  const asked = useAsked(String(most), AGAIN_MS, (signal) => events(0, Math.ceil(live().now) + 60_000, most, signal))
  const all = asked.value ?? []
  const shown = all.filter(
    (event) =>
      (!kind || event.kind === kind) && `${event.gauge ?? ''} ${event.text}`.toLowerCase().includes(text.toLowerCase()),
  )
  return (
    <section class="panel events" aria-label="Events">
      <div class="bar">
        <h1>Events</h1>
        <select
          aria-label="Kind"
          value={kind}
          onChange={(event) => setKind(event.currentTarget.value as EventKind | '')}
        >
          <option value="">all kinds</option>
          {Object.entries(KINDS).map(([kind, word]) => (
            <option value={kind} key={kind}>
              {word}
            </option>
          ))}
        </select>
        <input
          type="search"
          placeholder="Search"
          aria-label="Search events"
          value={text}
          onInput={(event) => setText(event.currentTarget.value)}
        />
      </div>
      {asked.error && <p class="alarm">{asked.error}</p>}
      <table>
        <thead>
          <tr>
            <th>Time</th>
            <th>Kind</th>
            <th>Gauge</th>
            <th>What</th>
          </tr>
        </thead>
        <tbody>
          {shown.map(({ at_ms, kind, gauge, text }) => (
            <tr key={`${at_ms} ${text}`}>
              <td class="time">
                <span class="muted">{day(at_ms)}</span> {clock(at_ms)}
              </td>
              <td>
                <span class={`kind ${kind}`}>{KINDS[kind]}</span>
              </td>
              <td>{gauge && <Link to={gaugePath(gauge)}>{gauge}</Link>}</td>
              <td>{text}</td>
            </tr>
          ))}
        </tbody>
      </table>
      {asked.value && shown.length === 0 && (
        <p class="muted">{all.length > 0 ? 'Nothing matches.' : 'Nothing has happened yet.'}</p>
      )}
      {all.length === most && (
        <button type="button" onClick={() => setMost(most + PAGE)}>
          Older ones
        </button>
      )}
    </section>
  )
}
