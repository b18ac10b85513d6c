// An alarm in a list of those that are shelved, out of service or suppressed.

import './item.css'
import type { ComponentChildren, JSX } from 'preact'
import type { Alarm, ChangedAlarms } from '../../api/types.ts'
import { AlarmStateMark, PriorityMark } from '../../components/alarm-marks.tsx'
import { Unbroken } from '../../components/unbroken.tsx'
import { isActive } from '../../lib/alarms.ts'
import { clock, day, moment } from '../../lib/format.ts'
import { useLive } from '../../live.ts'

/** Runs an action on alarms and shows its error. */
export type RunAction = (action: () => Promise<unknown>) => void

interface Props {
  alarm: Alarm
  buttons: ComponentChildren
  children: ComponentChildren
}

export function AlarmItem({ alarm: { name, priority, state }, buttons, children }: Props): JSX.Element {
  return (
    <li class={`alarm-item alarm-card ${priority} ${state}`} data-alarm={name} data-priority={priority}>
      <div class="marks">
        <PriorityMark priority={priority} active={isActive({ state })} />
        <AlarmStateMark state={state} />
      </div>
      <div class="description">
        <strong>
          <Unbroken text={name} />
        </strong>
        {children}
      </div>
      <div class="actions">{buttons}</div>
    </li>
  )
}

/** Lists whose buttons work while the station is connected: otherwise no action reaches it. */
export function Actions({ children }: { children: ComponentChildren }): JSX.Element {
  return (
    <fieldset class="alarm-actions" disabled={!useLive().connected}>
      {children}
    </fieldset>
  )
}

/** Throws the reasons of the alarms that were not changed. */
export function refusals({ refused }: Pick<ChangedAlarms, 'refused'>): void {
  if (refused.length > 0) throw new Error(refused.map(({ problem }) => problem).join('; '))
}

/** The time; with the day unless it is today. */
export const shortTime = (at: number, now: number): string => (day(at) === day(now) ? clock(at) : moment(at))
