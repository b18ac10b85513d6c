// The dialog of a command or a new parameter value, in two steps: it is armed, then sent.

import './command-dialog.css'
import type { JSX } from 'preact'
import { useEffect, useState } from 'preact/hooks'
import { arm, conditionsOf, disarm, sendArmed } from '../api/calls.ts'
import type { ArmedCommand, Condition, Outcome, Request, Risk } from '../api/types.ts'
import { commandWords } from '../lib/commands.ts'
import { readable } from '../lib/format.ts'
import { t } from '../texts/texts.ts'
import { errorText, useModal } from './hooks.ts'

/** The countdown is drawn this often. */
const TICK_MS = 200

type State =
  | { step: 'checking' }
  | { step: 'armed'; armed: ArmedCommand; until: number }
  | { step: 'sending'; armed: ArmedCommand }
  | { step: 'done'; armed: ArmedCommand; outcome: Outcome }
  | { step: 'refused'; problem: string; conditions: Condition[] }
  | { step: 'expired' }

interface Props {
  gauge: string
  request: Request
  /** Called when the dialog closes; with the outcome if the command was sent. */
  close: (outcome: Outcome | null) => void
}

export function CommandDialog({ gauge, request, close }: Props): JSX.Element {
  const dialog = useModal()
  const [state, setState] = useState<State>({ step: 'checking' })
  const refused = (error: unknown): void =>
    setState({ step: 'refused', problem: errorText(error), conditions: conditionsOf(error) })
  useEffect(() => {
    let isClosed = false
    arm(gauge, request).then(
      (armed) => {
        if (isClosed) void disarm(armed.id).catch(() => {})
        else setState({ step: 'armed', armed, until: performance.now() + armed.expires_in_ms })
      },
      (error: unknown) => {
        if (!isClosed) refused(error)
      },
    )
    return () => {
      isClosed = true
    }
  }, [])
  // The harmless button has the focus, so that Enter pressed once too often sends nothing.
  useEffect(() => dialog.current?.querySelector<HTMLButtonElement>('.buttons button:not(.send)')?.focus(), [state.step])
  const leave = (): void => {
    if (state.step === 'armed') disarm(state.armed.id).catch(() => {})
    close(state.step === 'done' ? state.outcome : null)
  }
  const send = (armed: ArmedCommand): void => {
    setState({ step: 'sending', armed })
    sendArmed(armed.id).then((outcome) => setState({ step: 'done', armed, outcome }), refused)
  }
  // A command that is being sent cannot be cancelled: the dialog stays until the outcome is known.
  const cancel = (event: Event): void => {
    if (state.step === 'sending') event.preventDefault()
  }
  return (
    <dialog
      ref={dialog}
      class={`command-dialog ${state.step}`}
      onClose={leave}
      onCancel={cancel}
      aria-label={'command' in request ? t.command.label : t.command.change}
    >
      <h2>
        {'command' in request ? commandWords(request.command, []) : `${request.target} = ${request.value}`}{' '}
        <span class="muted">{gauge}</span>
      </h2>
      <div aria-live="polite">
        <Body state={state} />
      </div>
      <form method="dialog" class="buttons">
        {state.step === 'armed' && (
          <button type="button" class="main send" onClick={() => send(state.armed)}>
            {t.command.send}
          </button>
        )}
        {state.step !== 'sending' && <button type="submit">{closeLabel(state.step)}</button>}
        {state.step === 'armed' && <Countdown until={state.until} expired={() => setState({ step: 'expired' })} />}
      </form>
    </dialog>
  )
}

function closeLabel(step: State['step']): string {
  if (step === 'checking') return t.common.cancel
  return step === 'armed' ? t.command.disarm : t.common.close
}

function Body({ state }: { state: State }): JSX.Element {
  switch (state.step) {
    case 'checking':
      return <p class="progress busy">{t.command.checking}</p>
    case 'armed':
      return <Details armed={state.armed} />
    case 'sending':
      return (
        <>
          <Details armed={state.armed} />
          <p class="progress busy">{t.command.sending}</p>
        </>
      )
    case 'done':
      return <Result armed={state.armed} outcome={state.outcome} />
    case 'refused':
      return (
        <>
          <p class="error">{state.problem}</p>
          <Conditions conditions={state.conditions} />
        </>
      )
    case 'expired':
      return <p class="error">{t.command.expired}</p>
  }
}

function Details({ armed }: { armed: ArmedCommand }): JSX.Element {
  const { is_command, manual_name, before, after, octets, risk, conditions, from_device_file } = armed
  return (
    <>
      <dl class="details">
        <dt>{is_command ? t.command.command : t.command.parameter}</dt>
        <dd lang="en">{manual_name}</dd>
        <dt>{is_command ? t.command.sends : t.command.value}</dt>
        <dd>
          {!is_command && (
            <>
              <span class="before">{before ?? t.common.unknown}</span> →{' '}
            </>
          )}
          <strong>{after}</strong> <code>{octets}</code>
        </dd>
        <dt>{t.command.risk}</dt>
        <dd>
          <RiskMark risk={risk} /> <RiskText risk={risk} /> {from_device_file && <DeviceFileMark />}
        </dd>
      </dl>
      <Conditions conditions={conditions} />
    </>
  )
}

/** The sentence of the station about a risk, in the language of the user if it is known there. */
export function RiskText({ risk: { description } }: { risk: Risk }): JSX.Element {
  const own = t.riskSentence(description)
  return <span lang={own === description ? 'en' : undefined}>{own}</span>
}

export function RiskMark({ risk }: { risk: Risk }): JSX.Element {
  const { label, sentence } = t.risks[risk.class]
  return (
    <span class={`risk ${risk.class}`} title={sentence}>
      {label}
    </span>
  )
}

/** The mark of a command or parameter that a device file describes. */
export function DeviceFileMark(): JSX.Element {
  const { label, sentence } = t.deviceFile
  return (
    <span class="risk device-file" title={sentence}>
      {label}
    </span>
  )
}

function Conditions({ conditions }: { conditions: Condition[] }): JSX.Element | null {
  if (conditions.length === 0) return null
  return (
    <ul class="conditions">
      {conditions.map(({ expected, found, is_met }) => (
        <li class={is_met ? 'met' : 'unmet'} key={expected}>
          <span class="mark" role="img" aria-label={is_met ? t.command.met : t.command.notMet}>
            {is_met ? '✓' : '✗'}
          </span>{' '}
          <span lang="en">
            {readable(expected)} <span class="muted">· {readable(found)}</span>
          </span>
        </li>
      ))}
    </ul>
  )
}

function Result({ armed, outcome: { before, after } }: { armed: ArmedCommand; outcome: Outcome }): JSX.Element {
  return (
    <p class="success">
      {after === null
        ? t.command.done(armed.target)
        : t.command.changed(armed.target, before ?? t.common.unknown, <strong>{after}</strong>)}
    </p>
  )
}

function Countdown({ until, expired }: { until: number; expired: () => void }): JSX.Element {
  const [left, setLeft] = useState(until - performance.now())
  useEffect(() => {
    const timer = setInterval(() => setLeft(until - performance.now()), TICK_MS)
    return () => clearInterval(timer)
  }, [until])
  useEffect(() => {
    if (left <= 0) expired()
  }, [left <= 0])
  return <span class="muted">{t.command.armedFor(Math.max(0, Math.ceil(left / 1000)))}</span>
}
