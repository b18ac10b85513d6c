// Help over the page: keyboard shortcuts and the meaning of symbols.

import './help.css'
import type { JSX } from 'preact'
import type { AlarmState, BusStatus, RiskClass } from '../api/types.ts'
import { PRIORITIES } from '../lib/alarms.ts'
import { PAGES } from '../navigation.ts'
import { setShortcuts, useShortcuts } from '../settings.ts'
import { t } from '../texts/texts.ts'
import { AlarmStateMark, PriorityMark } from './alarm-marks.tsx'
import { BusStatusMark } from './bus-status.tsx'
import { DeviceFileMark, RiskMark } from './command-dialog.tsx'
import { useModal } from './hooks.ts'

/** The single-key shortcuts, which can be switched off. */
const singleKeys = (): [string, string][] => [
  ...PAGES.map(({ key, path }): [string, string] => [key, t.pages[path]]),
  ['u', t.help.nextUnit],
  ['t', t.help.nextTheme],
  ['?', t.help.this],
]

const otherKeys = (): [string, string][] => [
  [t.help.tab, t.help.next],
  ['← →', t.help.earlierLater],
  ['+ −', t.help.zoom],
  [t.help.home, t.help.present],
  [`${t.help.shift} ← →`, t.help.cursor],
  ['r', t.help.reference],
  [t.help.esc, t.help.escape],
]

export function Help({ close }: { close: () => void }): JSX.Element {
  const dialog = useModal()
  return (
    <dialog ref={dialog} onClose={close} aria-label={t.header.help} class="help">
      <div class="bar">
        <h2>{t.help.title}</h2>
        <button type="button" class="main" onClick={close}>
          {t.common.close}
        </button>
      </div>
      <p class="time-zone">{t.help.zone(Intl.DateTimeFormat().resolvedOptions().timeZone)}</p>
      <ShortcutSwitch />
      <Keys keys={singleKeys()} />
      <Keys keys={otherKeys()} />
      <h2>{t.help.bus}</h2>
      <dl class="keys marks">
        {(Object.keys(t.busStatus) as BusStatus[]).map((status) => (
          <Mark key={status} mark={<BusStatusMark status={status} />} text={t.busStatus[status].sentence} />
        ))}
      </dl>
      <h2>{t.pages['/alarms']}</h2>
      <dl class="keys marks">
        {PRIORITIES.map((priority) => (
          <Mark
            key={priority}
            mark={<PriorityMark priority={priority} active={true} />}
            text={t.alarms.ofPriority(t.priorities[priority])}
          />
        ))}
        {(Object.keys(t.alarms.states) as AlarmState[]).map((state) => (
          <Mark key={state} mark={<AlarmStateMark state={state} />} text={t.alarms.states[state].sentence} />
        ))}
      </dl>
      <h2>{t.help.risks}</h2>
      <dl class="keys marks">
        {(Object.keys(t.risks) as RiskClass[]).map((risk) => (
          <Mark key={risk} mark={<RiskMark risk={{ class: risk, description: '' }} />} text={t.risks[risk].sentence} />
        ))}
        <Mark mark={<DeviceFileMark />} text={t.deviceFile.sentence} />
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
      {t.help.switch}
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
