// Marks of alarms: colour, shape and word.

import './alarm-marks.css'
import type { JSX } from 'preact'
import type { Alarm, AlarmState, Priority, Snapshot } from '../api/types.ts'
import { ALARM_STATES, isActive, NUMBERS, summary } from '../lib/alarms.ts'
import { Link } from '../router.tsx'

/** The number of a priority in its shape: a square, a diamond or a circle. */
function PriorityShape({ priority }: { priority: Priority }): JSX.Element {
  return (
    <span class={`shape ${priority}`} aria-hidden="true">
      {NUMBERS[priority]}
    </span>
  )
}

export function PriorityMark({ priority }: { priority: Priority }): JSX.Element {
  return (
    <span class={`priority ${priority}`}>
      <PriorityShape priority={priority} /> {priority}
    </span>
  )
}

export function AlarmStateMark({ state }: { state: AlarmState }): JSX.Element {
  const { label, sentence } = ALARM_STATES[state]
  return (
    <span class={`alarm-state ${state}`} title={sentence}>
      {label}
    </span>
  )
}

/** In the header of all pages: the number of alarms, and the highest priority. */
export function AlarmBadge({ snapshot }: { snapshot: Snapshot }): JSX.Element {
  const { alarms } = snapshot
  const counts = summary(alarms)
  if (alarms.problem) {
    return (
      <Link to="/alarms" class="badge high" title={alarms.problem}>
        <span aria-hidden="true">✖ </span>alarms not monitored
      </Link>
    )
  }
  if (!counts) {
    return (
      <Link to="/alarms" class="badge none">
        <span aria-hidden="true">○ </span>no alarms
      </Link>
    )
  }
  const { priority, activeOfPriority, active, unacknowledged } = counts
  if (priority === null) {
    const text = `none active, ${unacknowledged} cleared and not acknowledged`
    return (
      <Link to="/alarms" class="badge cleared" title={text}>
        <span class="visually-hidden">Alarms: </span>
        <span aria-hidden="true">○ </span>
        {unacknowledged} cleared
      </Link>
    )
  }
  const text = `${active} active, ${unacknowledged} not acknowledged, highest priority ${priority}`
  return (
    <Link to="/alarms" class={`badge ${priority} ${unacknowledged ? '' : 'acknowledged'}`} title={text}>
      <span class="visually-hidden">Alarms: </span>
      <PriorityShape priority={priority} /> {activeOfPriority} {priority}
      {unacknowledged > 0 && (
        <span class="unacknowledged">
          , {unacknowledged} <span class="long">not acknowledged</span>
          <span class="short">unack.</span>
        </span>
      )}
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
            <PriorityShape priority={priority} /> {name}
          </Link>
        </li>
      ))}
    </ul>
  )
}
