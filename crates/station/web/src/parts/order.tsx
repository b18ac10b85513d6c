// The two steps of an act: the gauge is asked and the order armed; then it is fired, or not.

import type { JSX } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'
import { arm, conditionsOf, disarm, fire, type Armed, type Held, type Outcome, type Wish } from '../acting.ts'
import type { Risk } from '../api.ts'
import { RISKS } from '../pure/words.ts'
import { sentence } from './use.ts'

/** How often the countdown is drawn. */
const TICK_MS = 200

type Step =
  | { is: 'asking' }
  | { is: 'armed'; armed: Armed; until: number }
  | { is: 'firing'; armed: Armed }
  | { is: 'done'; armed: Armed; outcome: Outcome }
  | { is: 'refused'; problem: string; conditions: Held[] }
  | { is: 'over' }

interface Props {
  gauge: string
  wish: Wish
  /** It is closed; with what was done, if something was. */
  close: (outcome: Outcome | null) => void
}

export function OrderPanel({ gauge, wish, close }: Props): JSX.Element {
  const dialog = useRef<HTMLDialogElement>(null)
  const [step, setStep] = useState<Step>({ is: 'asking' })
  const refused = (error: unknown): void =>
    setStep({ is: 'refused', problem: sentence(error), conditions: conditionsOf(error) })
  useEffect(() => {
    let left = false
    dialog.current?.showModal()
    arm(gauge, wish).then(
      // Whoever has gone meanwhile does not want it.
      (armed) =>
        left
          ? void disarm(armed.order).catch(() => {})
          : setStep({ is: 'armed', armed, until: performance.now() + armed.left_ms }),
      (error: unknown) => left || refused(error),
    )
    return () => void (left = true)
  }, [])
  // What changes nothing has the focus: Enter pressed once too often fires nothing.
  useEffect(() => dialog.current?.querySelector<HTMLButtonElement>('.buttons button:not(.fire)')?.focus(), [step.is])
  const leave = (): void => {
    if (step.is === 'armed') disarm(step.armed.order).catch(() => {})
    close(step.is === 'done' ? step.outcome : null)
  }
  const pull = (armed: Armed): void => {
    setStep({ is: 'firing', armed })
    fire(armed.order).then((outcome) => setStep({ is: 'done', armed, outcome }), refused)
  }
  // What is being sent cannot be called back: the panel stays until it is known what came of it.
  const cancel = (event: Event): void => {
    if (step.is === 'firing') event.preventDefault()
  }
  return (
    <dialog ref={dialog} class={`order ${step.is}`} onClose={leave} onCancel={cancel} aria-label="Order">
      <h2>
        {'command' in wish ? wish.command : `${wish.target} = ${wish.value}`} <span class="muted">{gauge}</span>
      </h2>
      <div aria-live="polite">
        {step.is === 'asking' && <p class="progress busy">asking the gauge …</p>}
        {(step.is === 'armed' || step.is === 'firing') && <What armed={step.armed} />}
        {step.is === 'firing' && <p class="progress busy">sending …</p>}
        {step.is === 'refused' && <Refusal problem={step.problem} conditions={step.conditions} />}
        {step.is === 'done' && <Result armed={step.armed} outcome={step.outcome} />}
        {step.is === 'over' && <p class="alarm">The order has expired: nothing was sent.</p>}
      </div>
      <form method="dialog" class="buttons">
        {step.is === 'armed' ? (
          <>
            <button type="button" class="main fire" onClick={() => pull(step.armed)}>
              Fire
            </button>
            <button>Disarm</button>
            <Countdown until={step.until} over={() => setStep({ is: 'over' })} />
          </>
        ) : (
          step.is !== 'firing' && <button>{step.is === 'asking' ? 'Cancel' : 'Close'}</button>
        )}
      </form>
    </dialog>
  )
}

function What({ armed }: { armed: Armed }): JSX.Element {
  const { is_command, manual, before, after, octets, risk, conditions } = armed
  return (
    <>
      <dl class="what">
        <dt>{is_command ? 'Command' : 'Parameter'}</dt>
        <dd>{manual}</dd>
        <dt>{is_command ? 'Sends' : 'Value'}</dt>
        <dd>
          {!is_command && (
            <>
              <span class="before">{before ?? 'cannot be read'}</span> →{' '}
            </>
          )}
          <strong>{after}</strong> <code>{octets}</code>
        </dd>
        <dt>Risk</dt>
        <dd>
          <RiskMark risk={risk} /> {risk.words}
        </dd>
      </dl>
      <Conditions conditions={conditions} />
    </>
  )
}

export function RiskMark({ risk }: { risk: Risk }): JSX.Element {
  return <span class={`risk ${risk.class}`}>{RISKS[risk.class]}</span>
}

function Conditions({ conditions }: { conditions: Held[] }): JSX.Element | null {
  if (conditions.length === 0) return null
  return (
    <ul class="conditions">
      {conditions.map(({ wanted, found, holds }) => (
        <li class={holds ? 'holds' : 'fails'} key={wanted}>
          <span class="mark" role="img" aria-label={holds ? 'holds:' : 'does not hold:'}>
            {holds ? '✓' : '✗'}
          </span>{' '}
          {wanted} <span class="muted">· {found}</span>
        </li>
      ))}
    </ul>
  )
}

function Refusal({ problem, conditions }: { problem: string; conditions: Held[] }): JSX.Element {
  return (
    <>
      <p class="alarm">{problem}</p>
      <Conditions conditions={conditions} />
    </>
  )
}

function Result({ armed, outcome }: { armed: Armed; outcome: Outcome }): JSX.Element {
  const { before, after } = outcome
  return (
    <p class="success">
      Done: {armed.target}
      {after !== null && (
        <>
          {' '}
          was {before ?? 'unknown'} and reads <strong>{after}</strong>
        </>
      )}
      . It stands in the audit trail.
    </p>
  )
}

function Countdown({ until, over }: { until: number; over: () => void }): JSX.Element {
  const [left, setLeft] = useState(until - performance.now())
  useEffect(() => {
    const timer = setInterval(() => setLeft(until - performance.now()), TICK_MS)
    return () => clearInterval(timer)
  }, [until])
  useEffect(() => {
    if (left <= 0) over()
  }, [left <= 0])
  return <span class="muted countdown">armed for {Math.max(0, Math.ceil(left / 1000))} s</span>
}
