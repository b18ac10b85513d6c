// A standing alarm: one line with its columns, and its details below while it is open.

import './line.css'
import type { JSX } from 'preact'
import { acknowledge } from '../../api/calls.ts'
import type { Alarm } from '../../api/types.ts'
import { AlarmStateMark, PriorityMark } from '../../components/alarm-marks.tsx'
import { DrawnFor } from '../../components/drawn-for.tsx'
import { Unbroken } from '../../components/unbroken.tsx'
import { useLanguage } from '../../language.ts'
import { type HeadColumn, headDirection, type Order } from '../../lib/alarm-order.ts'
import { conditionText, isActive, isUnacknowledged, quantity } from '../../lib/alarms.ts'
import { age, readable } from '../../lib/format.ts'
import type { Unit } from '../../lib/units.ts'
import { useSecond } from '../../live.ts'
import { gaugePath, Link } from '../../router.tsx'
import { hasRole, useSession } from '../../session.ts'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'
import { type RunAction, shortTime } from './item.tsx'
import { SettingsButton } from './settings-dialog.tsx'
import type { Suppress } from './suppress-dialog.tsx'

interface LineActions {
  run: RunAction
  suppress: (suppress: Suppress) => void
  edit: (alarm: Alarm) => void
  /** Without it the line has no tick. */
  tick?: (isTicked: boolean) => void
  open: (isOpen: boolean) => void
}

interface Props extends LineActions {
  alarm: Alarm
  /** The present value, if it is known. */
  value: number | null
  /** Whether the alarm has ended while the user works in the list. */
  isGone: boolean
  isTicked: boolean
  isOpen: boolean
  connected: boolean
  /** A time of the present day. */
  now: number
  /** The present day, as it is shown. */
  today: string
}

/** Sorts the list by its heads; without it they are words. */
interface Sorting {
  order: Order
  press: (column: HeadColumn) => void
}

/** The heads of the columns. A press sorts; by keyboard and for a screen reader the choice of the order does the same. */
export function AlarmHead({ sorting = null }: { sorting?: Sorting | null }): JSX.Element {
  const { columns } = t.alarms
  return (
    <div class="alarm-head" aria-hidden="true">
      <span />
      <Head column="priority" text={t.common.priority} sorting={sorting} />
      <Head column="state" text={t.common.state} sorting={sorting} />
      <Head column="raised" text={columns.raised} sorting={sorting} />
      <Head column="gauge" text={t.common.gauge} sorting={sorting} />
      <Head column="alarm" text={t.common.alarm} sorting={sorting} />
      <span>{columns.limit}</span>
      <span>{columns.now}</span>
      <span class="when-raised">{columns.whenRaised}</span>
    </div>
  )
}

interface HeadProps {
  column: HeadColumn
  text: string
  sorting: Sorting | null
}

function Head({ column, text, sorting }: HeadProps): JSX.Element {
  if (!sorting) return <span>{text}</span>
  const direction = headDirection(sorting.order, column)
  return (
    <button type="button" tabIndex={-1} data-direction={direction} onClick={() => sorting.press(column)}>
      {text}
      {direction && (direction === 'ascending' ? ' ▴' : ' ▾')}
    </button>
  )
}

export function AlarmLine(props: Props): JSX.Element {
  const { alarm, value, isGone, isTicked, isOpen, connected, today } = props
  const [session, unit, language] = [useSession(), useUnit(), useLanguage()]
  return (
    <DrawnFor
      what={[alarm, value, isGone, isTicked, isOpen, connected, today, session.role, unit, language]}
      draw={() => <Line {...props} unit={unit} mayAct={hasRole(session, 'operator') && !isGone} />}
    />
  )
}

function Line(props: Props & { unit: Unit; mayAct: boolean }): JSX.Element {
  const { alarm, value, isGone, isTicked, isOpen, connected, now, unit, mayAct, tick, open, run } = props
  const { name, priority, state, raised_ms, gauge, message, occurrence } = alarm
  const { columns } = t.alarms
  return (
    <li
      class={`alarm-item alarm-line ${priority} ${isGone ? 'gone' : state}`}
      data-alarm={name}
      data-priority={priority}
    >
      <span class="tick">
        {mayAct && tick && (
          <input
            type="checkbox"
            aria-label={t.alarms.select(name)}
            checked={isTicked}
            onChange={({ currentTarget }) => tick(currentTarget.checked)}
          />
        )}
      </span>
      <PriorityMark priority={priority} active={!isGone && isActive({ state })} />
      {isGone ? <span class="alarm-state ended">{t.alarms.ended}</span> : <AlarmStateMark state={state} />}
      <span class="time">{raised_ms !== null && shortTime(raised_ms, now)}</span>
      <span class="gauge">{gauge && <Link to={gaugePath(gauge)}>{gauge}</Link>}</span>
      <span class="description">
        <button type="button" class="name" aria-expanded={isOpen} title={name} onClick={() => open(!isOpen)}>
          <span aria-hidden="true">{isOpen ? '▾' : '▸'} </span>
          <strong>
            <Unbroken text={name} />
          </strong>
        </button>
        {message && !isOpen && (
          <span class="message" title={message}>
            {message}
          </span>
        )}
      </span>
      {hasValues(alarm) ? (
        <>
          <Value of="limit" label={columns.limit} text={signOf(alarm) + quantity(alarm.limit, alarm.unit, unit)} />
          <Value of="now" label={connected ? columns.now : columns.last} text={quantity(value, alarm.unit, unit)} />
          <Value of="when-raised" label={columns.whenRaised} text={quantity(alarm.raised_value, alarm.unit, unit)} />
        </>
      ) : (
        <span class="cause">
          <Cause alarm={alarm} />
        </span>
      )}
      <span class="act">
        {mayAct && isUnacknowledged(alarm) && (
          <button
            type="button"
            class={isActive(alarm) ? 'main acknowledge' : 'acknowledge'}
            aria-label={t.alarms.acknowledgeOf(name)}
            // A key that is held down acknowledges one alarm, and not all that follow.
            onKeyDown={(event) => event.repeat && event.preventDefault()}
            onClick={() => run(() => acknowledge(name, occurrence))}
          >
            {t.alarms.acknowledge}
          </button>
        )}
      </span>
      {isOpen && <Details {...props} />}
    </li>
  )
}

const hasValues = ({ raised_value, limit }: Alarm): boolean => raised_value !== null && limit !== null

/** What a value is compared with its limit for, as a sign. The name of an alarm about a point says it. */
function signOf({ condition }: Alarm): string {
  if (condition === 'below') return '< '
  if (condition === 'several') return '≥ '
  return condition === 'point' ? '' : '> '
}

/** A value with the name of its column, which a wide page shows above the list. */
function Value({ of, label, text }: { of: string; label: string; text: string }): JSX.Element {
  return (
    <span class={`value ${of}`}>
      {text && <span class="label">{label} </span>}
      {text}
    </span>
  )
}

function Details({ alarm, mayAct, suppress, edit }: Props & { mayAct: boolean }): JSX.Element {
  const session = useSession()
  const shown = useUnit()
  const { name, message } = alarm
  return (
    <div class="details">
      {message && <p class="message">{message}</p>}
      <p>{hasValues(alarm) ? <Unbroken text={conditionText(alarm, shown)} /> : <Cause alarm={alarm} />}</p>
      <Times alarm={alarm} />
      {mayAct && (
        <div class="actions">
          <button
            type="button"
            class="shelve"
            aria-label={t.alarms.shelveOf(name)}
            onClick={() => suppress({ kind: 'shelve', alarms: [alarm] })}
          >
            {t.alarms.shelve}
          </button>
          {hasRole(session, 'engineer') && (
            <button
              type="button"
              class="take-out"
              aria-label={t.alarms.outOfServiceOf(name)}
              onClick={() => suppress({ kind: 'out-of-service', alarms: [alarm] })}
            >
              {t.alarms.outOfService}
            </button>
          )}
          <SettingsButton alarm={alarm} open={edit} />
        </div>
      )}
    </div>
  )
}

/** The condition in the language of the user, and the words of the station, which are English: an English reader needs only these. */
function Cause({ alarm }: { alarm: Alarm }): JSX.Element {
  const shown = useUnit()
  const isEnglish = useLanguage() === 'en'
  const { text, state } = alarm
  const words = text && <Unbroken text={readable(text)} />
  return (
    <>
      {/* The words say what is: of a cleared alarm, what was. */}
      {state === 'returned' && `${t.alarms.whenItWasRaised} `}
      {(!words || !isEnglish) && <Unbroken text={conditionText(alarm, shown)} />}
      {words && (
        <span lang="en" class={isEnglish ? undefined : 'muted'}>
          {!isEnglish && ' · '}
          {words}
        </span>
      )}
    </>
  )
}

function Times({ alarm }: { alarm: Alarm }): JSX.Element {
  const now = useSecond()
  const { raised_ms, acknowledged_by, acknowledged_ms, state, since_ms } = alarm
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
    </p>
  )
}
