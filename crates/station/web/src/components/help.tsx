// Help over the page: keyboard shortcuts and the meaning of symbols.

import './help.css'
import type { JSX } from 'preact'
import type { AlarmState, BusStatus, RiskClass } from '../api/types.ts'
import { ALARM_STATES, PRIORITIES } from '../lib/alarms.ts'
import { BUS_STATUS, RISKS } from '../lib/labels.ts'
import { PAGES } from '../navigation.ts'
import { setShortcuts, useShortcuts } from '../settings.ts'
import { AlarmStateMark, PriorityMark } from './alarm-marks.tsx'
import { BusStatusMark } from './bus-status.tsx'
import { RiskMark } from './command-dialog.tsx'
import { useModal } from './hooks.ts'

/** The single-key shortcuts, which can be switched off. */
const SINGLE_KEYS: [string, string][] = [
  ...PAGES.map(({ key, name }): [string, string] => [key, name]),
  ['u', 'next unit'],
  ['t', 'next theme: as the system, light, dark'],
  ['?', 'this help'],
]

const OTHER_KEYS: [string, string][] = [
  ['Tab', 'next button, link or field'],
  ['← →', 'earlier and later, in a chart'],
  ['+ −', 'zoom in and out, in a chart'],
  ['Home', 'back to the present, in a chart'],
  ['Shift ← →', 'moves the cursor, in the chart of trends'],
  ['r', 'sets the reference, in the chart of trends'],
  ['Esc', 'close a dialog; disarm a command'],
]

export function Help({ close }: { close: () => void }): JSX.Element {
  const dialog = useModal()
  return (
    <dialog ref={dialog} onClose={close} aria-label="Help" class="help">
      <div class="bar">
        <h2>Keyboard shortcuts</h2>
        <button type="button" class="main" onClick={close}>
          Close
        </button>
      </div>
      <ShortcutSwitch />
      <Keys keys={SINGLE_KEYS} />
      <Keys keys={OTHER_KEYS} />
      <h2>Bus status</h2>
      <dl class="keys marks">
        {(Object.keys(BUS_STATUS) as BusStatus[]).map((status) => (
          <Mark key={status} mark={<BusStatusMark status={status} />} text={BUS_STATUS[status].sentence} />
        ))}
      </dl>
      <h2>Alarms</h2>
      <dl class="keys marks">
        {PRIORITIES.map((priority) => (
          <Mark key={priority} mark={<PriorityMark priority={priority} />} text={`An alarm of ${priority} priority.`} />
        ))}
        {(Object.keys(ALARM_STATES) as AlarmState[]).map((state) => (
          <Mark key={state} mark={<AlarmStateMark state={state} />} text={ALARM_STATES[state].sentence} />
        ))}
      </dl>
      <h2>Risk of commands and parameters</h2>
      <dl class="keys marks">
        {(Object.keys(RISKS) as RiskClass[]).map((risk) => (
          <Mark key={risk} mark={<RiskMark risk={{ class: risk, description: '' }} />} text={RISKS[risk].sentence} />
        ))}
      </dl>
    </dialog>
  )
}

/** Single keys disturb users of speech input, who can switch them off here (WCAG 2.1.4). */
function ShortcutSwitch(): JSX.Element {
  const on = useShortcuts()
  return (
    <label class="switch">
      <input type="checkbox" checked={on} onChange={(event) => setShortcuts(event.currentTarget.checked)} />
      Single-key shortcuts
    </label>
  )
}

function Keys({ keys }: { keys: [string, string][] }): JSX.Element {
  return (
    <dl class="keys">
      {keys.map(([key, text]) => (
        <div key={key}>
          <dt>
            <kbd>{key}</kbd>
          </dt>
          <dd>{text}</dd>
        </div>
      ))}
    </dl>
  )
}

function Mark({ mark, text }: { mark: JSX.Element; text: string }): JSX.Element {
  return (
    <div>
      <dt>{mark}</dt>
      <dd>{text}</dd>
    </div>
  )
}
