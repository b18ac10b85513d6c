// The alarms that are shelved, out of service or suppressed by a plant state, with the reason.

import type { JSX } from 'preact'
import { returnToService, unshelve } from '../../api/calls.ts'
import type { Alarm } from '../../api/types.ts'
import { ClosedPart } from '../../components/closed-part.tsx'
import { Unbroken } from '../../components/unbroken.tsx'
import { useSecond, useSnapshot } from '../../live.ts'
import { hasRole, useSession } from '../../session.ts'
import { t } from '../../texts/texts.ts'
import { AlarmItem, type RunAction, refusals, shortTime } from './item.tsx'

interface Props {
  alarms: Alarm[]
  run: RunAction
}

export function ShelvedList({ alarms, run }: Props): JSX.Element | null {
  const mayUnshelve = hasRole(useSession(), 'operator')
  const shelved = alarms.filter(({ state }) => state === 'shelved')
  if (shelved.length === 0) return null
  const end = (names: string[]): void => run(() => unshelve(names).then(refusals))
  return (
    <section class="panel" aria-label={t.alarms.shelved}>
      <div class="bar">
        <h2>{t.alarms.shelved}</h2>
        {mayUnshelve && shelved.length > 1 && (
          <button type="button" onClick={() => end(shelved.map(({ name }) => name))}>
            {t.alarms.unshelveAll(shelved.length)}
          </button>
        )}
      </div>
      <ul class="alarm-list">
        {shelved.map((alarm) => (
          <AlarmItem
            alarm={alarm}
            key={alarm.name}
            buttons={
              mayUnshelve && (
                <button type="button" onClick={() => end([alarm.name])}>
                  {t.alarms.unshelve}
                </button>
              )
            }
          >
            <Reason suppression={alarm.shelved} />
          </AlarmItem>
        ))}
      </ul>
    </section>
  )
}

export function OutOfServiceList({ alarms, run }: Props): JSX.Element | null {
  const mayReturn = hasRole(useSession(), 'engineer')
  const out = alarms.filter(({ state }) => state === 'out-of-service')
  if (out.length === 0) return null
  return (
    <section class="panel" aria-label={t.alarms.outOfServiceTitle}>
      <h2>{t.alarms.outOfServiceTitle}</h2>
      <ul class="alarm-list">
        {out.map((alarm) => (
          <AlarmItem
            alarm={alarm}
            key={alarm.name}
            buttons={
              mayReturn && (
                <button type="button" onClick={() => run(() => returnToService(alarm.name))}>
                  {t.alarms.returnToService}
                </button>
              )
            }
          >
            <Reason suppression={alarm.out_of_service} />
          </AlarmItem>
        ))}
      </ul>
    </section>
  )
}

export function SuppressedList({ alarms }: Pick<Props, 'alarms'>): JSX.Element | null {
  const { alarms: active } = useSnapshot().alarms
  // The list was fetched some time ago: an alarm that has been raised since then is not suppressed any more.
  const suppressed = alarms.filter(
    ({ state, name }) => state === 'suppressed' && !active.some((alarm) => alarm.name === name),
  )
  if (suppressed.length === 0) return null
  return (
    <section class="panel" aria-label={t.plantStates.suppressed}>
      <ClosedPart
        title={t.plantStates.suppressedTitle(suppressed.length)}
        draw={() => (
          <ul class="alarm-list">
            {suppressed.map((alarm) => (
              <AlarmItem alarm={alarm} key={alarm.name} buttons={null}>
                <Reason suppression={alarm.suppressed} />
              </AlarmItem>
            ))}
          </ul>
        )}
      />
    </section>
  )
}

function Reason({ suppression }: { suppression: Alarm['shelved'] }): JSX.Element | null {
  const now = useSecond()
  if (!suppression) return null
  const { user, at_ms, reason, until_ms } = suppression
  return (
    <>
      <p>{reason}</p>
      <p class="muted">
        <Unbroken
          text={`${user}, ${shortTime(at_ms, now)}, ${
            until_ms == null ? t.alarms.untilReturned : t.alarms.until(shortTime(until_ms, now))
          }`}
        />
      </p>
    </>
  )
}
