// Marks of alarms: colour, shape and word.

import './alarm-marks.css'
import type { JSX } from 'preact'
import type { Alarm, AlarmState, Priority, Snapshot } from '../api/types.ts'
import {
  type AlarmSummary,
  countsText,
  isActive,
  lowerText,
  moreUrgent,
  NUMBERS,
  type PriorityCount,
  summary,
} from '../lib/alarms.ts'
import { Link } from '../router.tsx'
import { t } from '../texts/texts.ts'
import { Unbroken } from './unbroken.tsx'

/** The number of a priority in its shape: a square, a diamond or a circle. */
function PriorityShape({ priority }: { priority: Priority }): JSX.Element {
  return (
    <span class={`shape ${priority}`} aria-hidden="true">
      {NUMBERS[priority]}
    </span>
  )
}

/** The priority of an alarm; without colour unless the alarm is active. */
export function PriorityMark({ priority, active }: { priority: Priority; active: boolean }): JSX.Element {
  return (
    <span class={`priority ${active ? priority : 'inactive'}`}>
      <PriorityShape priority={priority} /> {t.priorities[priority] ?? priority}
    </span>
  )
}

export function AlarmStateMark({ state }: { state: AlarmState }): JSX.Element {
  const { label, sentence } = t.alarms.states[state]
  return (
    <span class={`alarm-state ${state}`} title={sentence}>
      {label}
    </span>
  )
}

/** The active alarms by priority, with the shape and colour of the highest one: `1 high, 3 medium`. */
export function AlarmCounts({ counts }: { counts: PriorityCount[] }): JSX.Element | null {
  const [highest, ...lower] = counts
  if (!highest) return null
  return (
    <>
      <span class={`priority ${highest.priority}`}>
        <PriorityShape priority={highest.priority} /> {countsText([highest])}
      </span>
      {lower.length > 0 && (
        <span class="lower">
          , <span class="long">{countsText(lower)}</span>
          <span class="short">{lowerText(lower)}</span>
        </span>
      )}
    </>
  )
}

/** The same, and how many alarms are not acknowledged. */
export function AlarmSummaryText({ summary }: { summary: AlarmSummary }): JSX.Element {
  const { active, unacknowledged } = summary
  const waiting = moreUrgent(summary)
  return (
    <>
      <AlarmCounts counts={active} />
      {active.length > 0 && unacknowledged > 0 && <span class="lower">, </span>}
      {unacknowledged > 0 && (
        <span class="not-acknowledged">
          {unacknowledged} <span class="long">{t.alarms.badge.notAcknowledged}</span>
          <span class="short">{t.alarms.badge.short}</span>
          {waiting && ` (${t.alarms.badge.cleared(countsText([waiting]))})`}
        </span>
      )}
    </>
  )
}

/** In the header of all pages: the number of alarms of each priority. */
export function AlarmBadge({ snapshot, current }: { snapshot: Snapshot; current: boolean }): JSX.Element {
  const { alarms } = snapshot
  const counts = summary(alarms)
  if (!current) {
    return (
      <Link to="/alarms" class="badge stale">
        <span class="visually-hidden">{t.alarms.badge.prefix}</span>
        {t.alarms.badge.lastKnown} {counts ? <AlarmSummaryText summary={counts} /> : t.alarms.badge.none}
      </Link>
    )
  }
  if (alarms.problem) {
    return (
      <Link to="/alarms" class="badge high" title={alarms.problem}>
        <span aria-hidden="true">✖ </span>
        {t.alarms.badge.notMonitored}
      </Link>
    )
  }
  if (!counts) {
    return (
      <Link to="/alarms" class="badge none">
        <span aria-hidden="true">○ </span>
        {t.alarms.badge.none}
      </Link>
    )
  }
  const { active, unacknowledgedCounts, unacknowledged } = counts
  const [highest] = active
  if (!highest) {
    return (
      <Link to="/alarms" class="badge cleared" title={t.alarms.badge.onlyCleared(unacknowledged)}>
        <span class="visually-hidden">{t.alarms.badge.prefix}</span>
        {unacknowledgedCounts[0] && (
          <span class="priority inactive">
            <PriorityShape priority={unacknowledgedCounts[0].priority} />
          </span>
        )}{' '}
        {t.alarms.badge.cleared(countsText(unacknowledgedCounts))},{' '}
        <span class="long">{t.alarms.badge.notAcknowledged}</span>
        <span class="short">{t.alarms.badge.short}</span>
      </Link>
    )
  }
  const text = t.alarms.badge.title(countsText(active), unacknowledged)
  return (
    <Link to="/alarms" class={`badge ${highest.priority} ${unacknowledged ? '' : 'acknowledged'}`} title={text}>
      <span class="visually-hidden">{t.alarms.badge.prefix}</span>
      <AlarmSummaryText summary={counts} />
    </Link>
  )
}

/** On the card of a gauge: its active alarms. */
export function CardAlarms({ alarms }: { alarms: Alarm[] }): JSX.Element | null {
  const active = alarms.filter(isActive)
  if (active.length === 0) return null
  return (
    <ul class="card-alarms">
      {active.map(({ name, priority }) => (
        <li key={name} class={`priority ${priority}`}>
          <Link to="/alarms">
            <PriorityShape priority={priority} /> <Unbroken text={name} />
          </Link>
        </li>
      ))}
    </ul>
  )
}
