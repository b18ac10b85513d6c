// Keys and marks, over everything.

import type { JSX } from 'preact'
import { useEffect, useRef } from 'preact/hooks'
import { PAGES } from './app.tsx'
import { ALARM_STATES, PRIORITIES } from './pure/alarms.ts'
import { RISK_SENTENCES, STANDINGS } from './pure/words.ts'
import { PriorityMark, StateMark } from './parts/alarm.tsx'
import { RiskMark } from './parts/order.tsx'
import { StandingMark } from './parts/standing.tsx'
import type { AlarmState, RiskClass, Standing } from './api.ts'

const KEYS = [
  ['u', 'next unit'],
  ['t', 'colours: as the system has them, light, dark'],
  ['Tab', 'to the next thing that can be pressed'],
  ['← →', 'earlier and later, in a chart'],
  ['+ −', 'closer and farther, in a chart'],
  ['Home', 'back to what happens now, in a chart'],
  ['Esc', 'closes what lies over the page, and disarms an order'],
  ['?', 'this'],
] as const

export function Help({ close }: { close: () => void }): JSX.Element {
  const dialog = useRef<HTMLDialogElement>(null)
  useEffect(() => dialog.current?.showModal(), [])
  return (
    <dialog ref={dialog} onClose={close} aria-label="Keys and marks" class="help">
      <div class="bar">
        <h2>Keys</h2>
        <button type="button" class="main" onClick={close}>
          Close
        </button>
      </div>
      <dl class="keys">
        {[...PAGES.map(({ key, name }) => [key, name] as const), ...KEYS].map(([key, words]) => (
          <div key={key}>
            <dt>
              <kbd>{key}</kbd>
            </dt>
            <dd>{words}</dd>
          </div>
        ))}
      </dl>
      <h2>Marks of gauges</h2>
      <dl class="keys marks">
        {(Object.keys(STANDINGS) as Standing[]).map((standing) => (
          <Mark key={standing} mark={<StandingMark standing={standing} />} words={STANDINGS[standing].sentence} />
        ))}
      </dl>
      <h2>Marks of alarms</h2>
      <dl class="keys marks">
        {PRIORITIES.map((priority) => (
          <Mark key={priority} mark={<PriorityMark priority={priority} />} words={`Of ${priority} priority.`} />
        ))}
        {(Object.keys(ALARM_STATES) as AlarmState[]).map((state) => (
          <Mark key={state} mark={<StateMark state={state} />} words={ALARM_STATES[state].sentence} />
        ))}
      </dl>
      <h2>Marks of commands and parameters</h2>
      <dl class="keys marks">
        {(Object.keys(RISK_SENTENCES) as RiskClass[]).map((risk) => (
          <Mark key={risk} mark={<RiskMark risk={{ class: risk, words: '' }} />} words={RISK_SENTENCES[risk]} />
        ))}
      </dl>
    </dialog>
  )
}

function Mark({ mark, words }: { mark: JSX.Element; words: string }): JSX.Element {
  return (
    <div>
      <dt>{mark}</dt>
      <dd>{words}</dd>
    </div>
  )
}
