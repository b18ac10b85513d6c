// Marks of alarms: colour, shape and word.

import type { JSX } from 'preact'
import type { Alarm, AlarmState, Moment, Priority } from '../api.ts'
import { ALARM_STATES, isActive, SHAPES, summary } from '../pure/alarms.ts'
import { Link } from '../router.tsx'

export function PriorityMark({ priority }: { priority: Priority }): JSX.Element {
  return (
    <span class={`priority ${priority}`}>
      <span class="shape" aria-hidden="true">
        {SHAPES[priority]}
      </span>{' '}
      {priority}
    </span>
  )
}

export function StateMark({ state }: { state: AlarmState }): JSX.Element {
  const { word, sentence } = ALARM_STATES[state]
  return (
    <span class={`alarm-state ${state}`} title={sentence}>
      {word}
    </span>
  )
}

/** In the frame of all pages: how many alarms there are, and how urgent the most urgent is. */
export function AlarmBadge({ moment }: { moment: Moment | null }): JSX.Element | null {
  if (!moment) return null
  const { alarms } = moment
  const all = summary(alarms)
  if (alarms.trouble) {
    return (
      <Link to="/alarms" class="badge high" title={alarms.trouble}>
        <span aria-hidden="true">✖ </span>alarms not watched
      </Link>
    )
  }
  if (!all) {
    return (
      <Link to="/alarms" class="badge calm">
        <span aria-hidden="true">○ </span>no alarms
      </Link>
    )
  }
  const { priority, here, active, unacknowledged } = all
  const words = `${active} active, ${unacknowledged} not acknowledged, the highest priority is ${priority}`
  return (
    <Link
      to="/alarms"
      class={`badge ${priority} ${unacknowledged ? '' : 'known'}`}
      title={words}
      aria-label={`Alarms: ${words}`}
    >
      <span aria-hidden="true">{SHAPES[priority]} </span>
      {here > 0 ? `${here} ${priority}` : `${priority}, over`}
      {unacknowledged > 0 && <span class="new"> {unacknowledged} new</span>}
    </Link>
  )
}

/** On the card of a gauge: the alarms it has. */
export function CardAlarms({ alarms }: { alarms: Alarm[] }): JSX.Element | null {
  const active = alarms.filter((alarm) => isActive(alarm))
  if (active.length === 0) return null
  return (
    <ul class="card-alarms">
      {active.map((alarm) => (
        <li key={alarm.name} class={`priority ${alarm.priority}`}>
          <Link to="/alarms">
            <span class="shape" aria-hidden="true">
              {SHAPES[alarm.priority]}
            </span>{' '}
            {alarm.name}
          </Link>
        </li>
      ))}
    </ul>
  )
}
