// The events of the window in one lane below the chart. Events that are close to each other share a mark with their number; a
// mark that is pressed lists them.

import './event-lane.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import type { StationEvent } from '../../api/types.ts'
import { PLOT_EDGES, timePixels } from '../../components/chart.tsx'
import { type EventGroup, eventGroups } from '../../lib/event-lane.ts'
import { moment, readable } from '../../lib/format.ts'
import { t } from '../../texts/texts.ts'

/** The width of a mark, which a finger can press. */
const MARK_PX = 24

/** The number of events that the accessible name of a mark has at most. */
const MOST_NAMED = 3

interface Props {
  events: StationEvent[]
  window: [number, number]
  width: number
}

export function EventLane({ events, window, width }: Props): JSX.Element {
  /** The time with which the open group begins. */
  const [open, setOpen] = useState<number | null>(null)
  const lane = timePixels(width, true)
  const groups = eventGroups(events, window, lane, MARK_PX)
  const opened = groups.find(({ at_ms }) => at_ms === open)
  return (
    <section class="event-lane" aria-label={t.trends.events}>
      <span class="lane-name" aria-hidden="true">
        {t.trends.lane}
      </span>
      <div class="lane" style={{ marginLeft: `${PLOT_EDGES.left}px`, width: `${lane}px` }}>
        {groups.map((group) => (
          <button
            type="button"
            key={group.at_ms}
            style={{ left: `${group.position * 100}%` }}
            aria-label={`${group.events.length}: ${nameOf(group)}`}
            aria-expanded={group === opened}
            title={nameOf(group)}
            onClick={() => setOpen(group === opened ? null : group.at_ms)}
          >
            {group.events.length}
          </button>
        ))}
      </div>
      {opened && (
        <ul>
          {opened.events.map(({ at_ms, text }) => (
            <li key={`${at_ms} ${text}`}>
              <time dateTime={new Date(at_ms).toISOString()}>{moment(at_ms)}</time> {readable(text)}
            </li>
          ))}
        </ul>
      )}
    </section>
  )
}

function nameOf({ events }: EventGroup): string {
  const named = events.slice(0, MOST_NAMED).map(({ at_ms, text }) => `${moment(at_ms)} ${readable(text)}`)
  const rest = events.length - named.length
  return [...named, ...(rest > 0 ? [t.trends.moreEvents(rest)] : [])].join('; ')
}
