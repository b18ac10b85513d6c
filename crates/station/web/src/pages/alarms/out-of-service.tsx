// The alarms that are out of service, with the reason.

import type { JSX } from 'preact'
import { returnToService } from '../../api/calls.ts'
import type { Alarm } from '../../api/types.ts'
import { useLive } from '../../live.ts'
import { hasRole, useSession } from '../../session.ts'
import { AlarmItem, type RunAction, shortTime } from './item.tsx'

export function OutOfServiceList({ alarms, run }: { alarms: Alarm[]; run: RunAction }): JSX.Element | null {
  const mayReturn = hasRole(useSession(), 'engineer')
  const out = alarms.filter(({ state }) => state === 'out-of-service')
  if (out.length === 0) return null
  return (
    <section class="panel" aria-label="Out of service">
      <h2>Out of service</h2>
      <ul class="alarm-list">
        {out.map((alarm) => (
          <AlarmItem
            alarm={alarm}
            key={alarm.name}
            buttons={
              mayReturn && (
                <button type="button" onClick={() => run(() => returnToService(alarm.name))}>
                  Return to service
                </button>
              )
            }
          >
            <Reason alarm={alarm} />
          </AlarmItem>
        ))}
      </ul>
    </section>
  )
}

function Reason({ alarm: { out_of_service } }: { alarm: Alarm }): JSX.Element | null {
  const { now } = useLive()
  if (!out_of_service) return null
  const { user, at_ms, reason, until_ms } = out_of_service
  return (
    <>
      <p>{reason}</p>
      <p class="muted">
        {user}, {shortTime(at_ms, now)},{' '}
        {until_ms === null ? 'until returned to service' : `until ${shortTime(until_ms, now)}`}
      </p>
    </>
  )
}
