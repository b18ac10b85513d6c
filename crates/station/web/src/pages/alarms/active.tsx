// Active and unacknowledged alarms, the most urgent first.

import type { JSX } from 'preact'
import { acknowledge, acknowledgeAll } from '../../api/calls.ts'
import type { Alarm } from '../../api/types.ts'
import { Unbroken } from '../../components/unbroken.tsx'
import { useLanguage } from '../../language.ts'
import { byUrgency, conditionText, isUnacknowledged, quantity } from '../../lib/alarms.ts'
import { age, readable } from '../../lib/format.ts'
import { useLive, useSnapshot } from '../../live.ts'
import { gaugePath, Link } from '../../router.tsx'
import { hasRole, useSession } from '../../session.ts'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'
import { AlarmItem, type RunAction, refusals, shortTime } from './item.tsx'
import { SettingsButton } from './settings-dialog.tsx'
import type { Suppress } from './suppress-dialog.tsx'

interface Props {
  /** Why the last action failed. */
  error: string | null
  run: RunAction
  suppress: (suppress: Suppress) => void
  edit: (alarm: Alarm) => void
}

export function ActiveAlarmList({ error, run, suppress, edit }: Props): JSX.Element {
  const { alarms } = useSnapshot()
  const list = [...alarms.alarms].sort(byUrgency)
  return (
    <section class="panel" aria-label={t.alarms.active}>
      <Head list={list} run={run} suppress={suppress} />
      {error && (
        <p class="error" role="alert">
          {error}
        </p>
      )}
      {alarms.problem && (
        <p class="error" role="alert">
          {t.alarms.mayBeWrong(alarms.problem)}
        </p>
      )}
      {list.length === 0 && <p class="muted no-alarms">{t.alarms.noneActive}</p>}
      <ul class="alarm-list">
        {list.map((alarm) => (
          <ActiveAlarm alarm={alarm} run={run} suppress={suppress} edit={edit} key={alarm.name} />
        ))}
      </ul>
      {alarms.not_listed > 0 && <p class="muted">{t.alarms.notListed(alarms.not_listed)}</p>}
    </section>
  )
}

function Head({ list, run, suppress }: Omit<Props, 'error' | 'edit'> & { list: Alarm[] }): JSX.Element {
  const mayAcknowledge = hasRole(useSession(), 'operator')
  const unacknowledged = list.filter(isUnacknowledged)
  const shown = unacknowledged.map(({ name, occurrence }) => ({ name, occurrence }))
  return (
    <div class="bar">
      <h1>{t.pages['/alarms']}</h1>
      {mayAcknowledge && unacknowledged.length > 1 && (
        <button type="button" onClick={() => run(() => acknowledgeAll(shown).then(refusals))}>
          {t.alarms.acknowledgeAll(unacknowledged.length)}
        </button>
      )}
      {mayAcknowledge && list.length > 1 && (
        <button type="button" onClick={() => suppress({ kind: 'shelve', alarms: list })}>
          {t.alarms.shelveAll(list.length)}
        </button>
      )}
      {!mayAcknowledge && unacknowledged.length > 0 && <span class="muted">{t.alarms.operatorCan}</span>}
    </div>
  )
}

function ActiveAlarm({ alarm, run, suppress, edit }: Omit<Props, 'error'> & { alarm: Alarm }): JSX.Element {
  const session = useSession()
  const { name, occurrence, message } = alarm
  return (
    <AlarmItem
      alarm={alarm}
      buttons={
        <>
          {isUnacknowledged(alarm) && hasRole(session, 'operator') && (
            <button type="button" class="main acknowledge" onClick={() => run(() => acknowledge(name, occurrence))}>
              {t.alarms.acknowledge}
            </button>
          )}
          {hasRole(session, 'operator') && (
            <button type="button" class="shelve" onClick={() => suppress({ kind: 'shelve', alarms: [alarm] })}>
              {t.alarms.shelve}
            </button>
          )}
          {hasRole(session, 'engineer') && (
            <button
              type="button"
              class="take-out"
              onClick={() => suppress({ kind: 'out-of-service', alarms: [alarm] })}
            >
              {t.alarms.outOfService}
            </button>
          )}
          <SettingsButton alarm={alarm} open={edit} />
        </>
      }
    >
      <Values alarm={alarm} />
      <Times alarm={alarm} />
      {message && <p class="message">{message}</p>}
    </AlarmItem>
  )
}

/** The condition, the value when the alarm was raised, and the value now. */
function Values({ alarm }: { alarm: Alarm }): JSX.Element {
  const shown = useUnit()
  const { connected } = useLive()
  const { raised_value, value, limit, unit } = alarm
  if (raised_value === null || limit === null) return <Cause alarm={alarm} />
  const raised = t.alarms.whenRaised(conditionText(alarm, shown), quantity(raised_value, unit, shown))
  const at = connected ? t.alarms.nowAt : t.alarms.lastAt
  return (
    <p>
      <Unbroken text={value === null ? raised : at(raised, quantity(value, unit, shown))} />
    </p>
  )
}

/** The condition in the language of the user, and the words of the station, which are English: an English reader needs only these. */
function Cause({ alarm }: { alarm: Alarm }): JSX.Element {
  const shown = useUnit()
  const isEnglish = useLanguage() === 'en'
  const { text, state } = alarm
  const words = text && <Unbroken text={readable(text)} />
  return (
    <p>
      {/* The words say what is: of a cleared alarm, what was. */}
      {state === 'returned' && `${t.alarms.whenItWasRaised} `}
      {(!words || !isEnglish) && <Unbroken text={conditionText(alarm, shown)} />}
      {words && (
        <span lang="en" class={isEnglish ? undefined : 'muted'}>
          {!isEnglish && ' · '}
          {words}
        </span>
      )}
    </p>
  )
}

function Times({ alarm }: { alarm: Alarm }): JSX.Element {
  const { now } = useLive()
  const { raised_ms, acknowledged_by, acknowledged_ms, gauge, state, since_ms } = alarm
  const times = [
    raised_ms !== null && t.alarms.raised(shortTime(raised_ms, now), age(Math.max(0, now - raised_ms))),
    acknowledged_by &&
      acknowledged_ms !== null &&
      t.alarms.acknowledgedBy(acknowledged_by, shortTime(acknowledged_ms, now)),
    state === 'returned' && since_ms !== null && t.alarms.cleared(shortTime(since_ms, now)),
  ]
  return (
    <p class="muted">
      <Unbroken text={times.filter(Boolean).join(' · ')} />
      {gauge && (
        <>
          {' · '}
          <Link to={gaugePath(gauge)}>{gauge}</Link>
        </>
      )}
    </p>
  )
}
