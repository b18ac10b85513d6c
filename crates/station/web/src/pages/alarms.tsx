// Alarms: what stands and what is new, what is out of service, what there is, and what was.

import type { JSX } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'
import {
  acknowledge,
  acknowledgeAll,
  alarmHistory,
  alarms,
  outOfService,
  returnToService,
  webhooks,
  type Alarm,
  type Webhook,
} from '../api.ts'
import { live, useLive } from '../live.ts'
import { StateMark, PriorityMark } from '../parts/alarm.tsx'
import { sentence, useAsked } from '../parts/use.ts'
import { byUrgency, isWanted, meaning, quantity, wantsAcknowledgement, WHATS } from '../pure/alarms.ts'
import { age, clock, day, moment } from '../pure/format.ts'
import { gaugePath, Link } from '../router.tsx'
import { may, useSession } from '../session.ts'
import { useUnit } from '../settings.ts'

/** All alarms are asked for anew so often; those that stand come with every moment. */
const AGAIN_MS = 2_000
const HISTORY_MS = 3_000
const PAGE = 100

export function Alarms(): JSX.Element {
  const { moment } = useLive()
  const standing = moment!.alarms
  const [done, setDone] = useState(0)
  const asked = useAsked(`alarms ${done}`, AGAIN_MS, (signal) => alarms(signal))
  const [problem, setProblem] = useState<string | null>(null)
  const [leaving, setLeaving] = useState<Alarm | null>(null)
  /** Does something, and shows what came of it at once. */
  const act = (what: () => Promise<unknown>): void => {
    setProblem(null)
    what()
      .catch((error: unknown) => setProblem(sentence(error)))
      .finally(() => setDone((count) => count + 1))
  }
  const all = asked.value ?? []
  const out = all.filter(({ state }) => state === 'out-of-service')
  const listed = [...standing.list].sort(byUrgency)
  return (
    <>
      <section class="panel alarms" aria-label="Alarms that stand">
        <Head listed={listed} act={act} />
        {problem && (
          <p class="alarm" role="alert">
            {problem}
          </p>
        )}
        {standing.trouble && (
          <p class="alarm" role="alert">
            What stands here may be wrong: {standing.trouble}.
          </p>
        )}
        {listed.length === 0 && <p class="muted calm">Nothing stands, and there is nothing new.</p>}
        <ul class="alarm-list">
          {listed.map((alarm) => (
            <Item alarm={alarm} act={act} leave={setLeaving} key={alarm.name} />
          ))}
        </ul>
        {standing.more > 0 && <p class="muted">{standing.more} more stand below, under All alarms.</p>}
      </section>
      {out.length > 0 && <OutOfService all={out} act={act} />}
      <Every all={all} error={asked.error} leave={setLeaving} />
      <History />
      <Hooks />
      {leaving && <Leaving alarm={leaving} act={act} close={() => setLeaving(null)} />}
    </>
  )
}

type Act = (what: () => Promise<unknown>) => void

function Head({ listed, act }: { listed: Alarm[]; act: Act }): JSX.Element {
  const mine = may(useSession(), 'operator')
  const fresh = listed.filter(wantsAcknowledgement)
  const seen = fresh.map(({ name, occurrence }) => ({ name, occurrence }))
  const all = async (): Promise<void> => {
    const { refused } = await acknowledgeAll(seen)
    if (refused.length > 0) throw new Error(refused.map(({ problem }) => problem).join('; '))
  }
  return (
    <div class="bar">
      <h1>Alarms</h1>
      {mine && fresh.length > 1 && (
        <button type="button" onClick={() => act(all)}>
          Acknowledge these {fresh.length}
        </button>
      )}
      {!mine && fresh.length > 0 && <span class="muted">An operator can acknowledge them.</span>}
    </div>
  )
}

function Item({ alarm, act, leave }: { alarm: Alarm; act: Act; leave: (alarm: Alarm) => void }): JSX.Element {
  const session = useSession()
  const { name, occurrence, priority, state } = alarm
  return (
    <li class={`alarm-item ${priority} ${state}`} data-alarm={name}>
      <div class="marks">
        <PriorityMark priority={priority} />
        <StateMark state={alarm.state} />
      </div>
      <div class="what">
        <strong>{name}</strong>
        <Text alarm={alarm} />
        {alarm.message && <p class="message">{alarm.message}</p>}
      </div>
      <div class="do">
        {wantsAcknowledgement(alarm) && may(session, 'operator') && (
          <button type="button" class="main" onClick={() => act(() => acknowledge(name, occurrence))}>
            Acknowledge
          </button>
        )}
        {may(session, 'engineer') && (
          <button type="button" onClick={() => leave(alarm)}>
            Out of service …
          </button>
        )}
      </div>
    </li>
  )
}

function Text({ alarm }: { alarm: Alarm }): JSX.Element {
  const unit = useUnit()
  const { now } = useLive()
  const { raised_ms, raised_value, value, limit, acknowledged_by, acknowledged_ms, gauge } = alarm
  const isCounted = raised_value !== null && limit !== null
  const facts = [
    isCounted
      ? `${meaning(alarm, unit)}: ${quantity(raised_value, alarm.unit, unit)} when it was raised`
      : alarm.text || meaning(alarm, unit),
    isCounted && value !== null ? `now ${quantity(value, alarm.unit, unit)}` : '',
  ].filter(Boolean)
  return (
    <>
      <p>{facts.join(', ')}</p>
      <p class="muted">
        {raised_ms !== null && `raised ${time(raised_ms, now)}, ${age(Math.max(0, now - raised_ms))} ago`}
        {acknowledged_by &&
          acknowledged_ms !== null &&
          ` · acknowledged by ${acknowledged_by} ${time(acknowledged_ms, now)}`}
        {gauge && (
          <>
            {' · '}
            <Link to={gaugePath(gauge)}>{gauge}</Link>
          </>
        )}
      </p>
    </>
  )
}

/** The clock, with the day unless it is today. */
const time = (at: number, now: number): string => (day(at) === day(now) ? clock(at) : moment(at))

function OutOfService({ all, act }: { all: Alarm[]; act: Act }): JSX.Element {
  const mine = may(useSession(), 'engineer')
  const { now } = useLive()
  return (
    <section class="panel" aria-label="Out of service">
      <h2>Out of service</h2>
      <ul class="alarm-list">
        {all.map(({ name, out_of_service: out, priority }) => (
          <li class="alarm-item out-of-service" data-out={name} key={name}>
            <div class="marks">
              <PriorityMark priority={priority} />
              <StateMark state="out-of-service" />
            </div>
            <div class="what">
              <strong>{name}</strong>
              {out && (
                <>
                  <p>{out.reason}</p>
                  <p class="muted">
                    {out.who}, {time(out.at_ms, now)}
                    {out.until_ms === null ? ', until somebody puts it back' : `, until ${time(out.until_ms, now)}`}
                  </p>
                </>
              )}
            </div>
            <div class="do">
              {mine && (
                <button type="button" onClick={() => act(() => returnToService(name))}>
                  Return to service
                </button>
              )}
            </div>
          </li>
        ))}
      </ul>
    </section>
  )
}

/** What there is, whether it stands or not. */
function Every({
  all,
  error,
  leave,
}: {
  all: Alarm[]
  error: string | null
  leave: (alarm: Alarm) => void
}): JSX.Element {
  const unit = useUnit()
  const mine = may(useSession(), 'engineer')
  const [text, setText] = useState('')
  const shown = all.filter((alarm) =>
    `${alarm.name} ${meaning(alarm, unit)}`.toLowerCase().includes(text.toLowerCase()),
  )
  return (
    <section class="panel" aria-label="All alarms">
      <details>
        <summary>
          <h2>All {all.length || ''} alarms</h2>
        </summary>
        <div class="bar">
          <input
            type="search"
            placeholder="Search"
            aria-label="Search alarms"
            value={text}
            onInput={(event) => setText(event.currentTarget.value)}
          />
        </div>
        {error && <p class="alarm">{error}</p>}
        {all.length > 0 && shown.length === 0 && <p class="muted">Nothing matches.</p>}
        <table class="every">
          <thead>
            <tr>
              <th>Alarm</th>
              <th>Priority</th>
              <th>State</th>
              <th>When</th>
              <th />
            </tr>
          </thead>
          <tbody>
            {shown.map((alarm) => (
              <tr key={alarm.name}>
                <td>{alarm.name}</td>
                <td>
                  <PriorityMark priority={alarm.priority} />
                </td>
                <td>
                  <StateMark state={alarm.state} />
                </td>
                <td>{meaning(alarm, unit)}</td>
                <td>
                  {mine && alarm.state !== 'out-of-service' && (
                    <button
                      type="button"
                      class="plain"
                      aria-label={`Out of service: ${alarm.name}`}
                      onClick={() => leave(alarm)}
                    >
                      Out of service …
                    </button>
                  )}
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      </details>
    </section>
  )
}

function History(): JSX.Element {
  const unit = useUnit()
  const [most, setMost] = useState(PAGE)
  const [what, setWhat] = useState('')
  const [text, setText] = useState('')
  const asked = useAsked(String(most), HISTORY_MS, (signal) =>
    alarmHistory(0, Math.ceil(live().now) + 60_000, most, signal),
  )
  const all = asked.value ?? []
  const shown = all.filter((event) => isWanted(event, what, text))
  return (
    <section class="panel events" aria-label="History">
      <div class="bar">
        <h2>History</h2>
        <select aria-label="What happened" value={what} onChange={(event) => setWhat(event.currentTarget.value)}>
          <option value="">everything</option>
          {Object.entries(WHATS).map(([what, word]) => (
            <option value={what} key={what}>
              {word}
            </option>
          ))}
        </select>
        <input
          type="search"
          placeholder="Search"
          aria-label="Search the history"
          value={text}
          onInput={(event) => setText(event.currentTarget.value)}
        />
      </div>
      {asked.error && <p class="alarm">{asked.error}</p>}
      <table>
        <thead>
          <tr>
            <th>Time</th>
            <th>Priority</th>
            <th>What</th>
            <th>Alarm</th>
            <th>Who</th>
            <th>Value</th>
          </tr>
        </thead>
        <tbody>
          {shown.map((event) => (
            <tr key={`${event.at_ms} ${event.alarm} ${event.what}`}>
              <td class="time">
                <span class="muted">{day(event.at_ms)}</span> {clock(event.at_ms)}
              </td>
              <td>
                <PriorityMark priority={event.priority} />
              </td>
              <td>{WHATS[event.what] ?? event.what}</td>
              <td>
                {event.alarm}
                {event.text && event.value === null && <span class="muted"> {event.text}</span>}
              </td>
              <td class="who">{event.who}</td>
              <td class="who">{quantity(event.value, event.unit, unit)}</td>
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

/** Who is told, if somebody is. */
function Hooks(): JSX.Element | null {
  const { now } = useLive()
  const asked = useAsked('webhooks', AGAIN_MS, (signal) => webhooks(signal))
  const all = asked.value ?? []
  if (all.length === 0) return null
  const how = ({ problem, failing_since_ms, waiting, delivered_ms }: Webhook): string => {
    if (problem) return `takes nothing since ${time(failing_since_ms ?? now, now)}: ${problem}`
    if (delivered_ms !== null) return `took the last one ${time(delivered_ms, now)}`
    return waiting > 0 ? 'is being told' : 'was not told anything yet'
  }
  return (
    <section class="panel" aria-label="Webhooks">
      <h2>Webhooks</h2>
      <ul class="hooks">
        {all.map((hook) => (
          <li key={hook.name} class={hook.problem ? 'bad' : ''}>
            <strong>{hook.name}</strong> <span class="muted">{hook.at}</span> {how(hook)}
            {hook.waiting > 0 && `, ${hook.waiting} wait`}
            {hook.given_up > 0 && `, ${hook.given_up} were given up`}
          </li>
        ))}
      </ul>
    </section>
  )
}

const TIMES: [string, number | null][] = [
  ['1 hour', 60],
  ['8 hours', 480],
  ['1 day', 1_440],
  ['1 week', 10_080],
  ['until it is put back', null],
]

function Leaving({ alarm, act, close }: { alarm: Alarm; act: Act; close: () => void }): JSX.Element {
  const dialog = useRef<HTMLDialogElement>(null)
  const [reason, setReason] = useState('')
  const [place, setPlace] = useState(0)
  useEffect(() => dialog.current?.showModal(), [])
  const submit = (event: Event): void => {
    event.preventDefault()
    act(() => outOfService(alarm.name, reason, TIMES[place]![1]))
    close()
  }
  return (
    <dialog ref={dialog} onClose={close} aria-label="Out of service" class="leaving">
      <h2>Take {alarm.name} out of service</h2>
      <p class="muted">It says nothing until it is back. If its condition holds then, it is raised at once.</p>
      <form onSubmit={submit}>
        <label>
          Why
          <input
            required
            maxLength={500}
            pattern=".*\S.*"
            value={reason}
            onInput={(event) => setReason(event.currentTarget.value)}
          />
        </label>
        <label>
          For how long
          <select value={place} onChange={(event) => setPlace(Number(event.currentTarget.value))}>
            {TIMES.map(([words], place) => (
              <option value={place} key={words}>
                {words}
              </option>
            ))}
          </select>
        </label>
        <div class="buttons">
          <button type="submit" class="main">
            Take out of service
          </button>
          <button type="button" onClick={close}>
            Cancel
          </button>
        </div>
      </form>
    </dialog>
  )
}
