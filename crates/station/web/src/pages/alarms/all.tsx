// All configured alarms, whether active or not.

import './all.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import type { Alarm } from '../../api/types.ts'
import { AlarmStateMark, PriorityMark } from '../../components/alarm-marks.tsx'
import { SearchField } from '../../components/fields.tsx'
import { conditionText } from '../../lib/alarms.ts'
import { hasRole, useSession } from '../../session.ts'
import { useUnit } from '../../settings.ts'

interface Props {
  alarms: Alarm[]
  error: string | null
  takeOut: (alarm: Alarm) => void
}

export function AllAlarms({ alarms, error, takeOut }: Props): JSX.Element {
  const unit = useUnit()
  const [text, setText] = useState('')
  const shown = alarms.filter((alarm) =>
    `${alarm.name} ${conditionText(alarm, unit)}`.toLowerCase().includes(text.toLowerCase()),
  )
  return (
    <section class="panel" aria-label="All alarms">
      <details>
        <summary>
          <h2>All {alarms.length || ''} alarms</h2>
        </summary>
        <div class="bar">
          <SearchField label="Search alarms" value={text} onInput={setText} />
        </div>
        {error && <p class="error">{error}</p>}
        {alarms.length > 0 && shown.length === 0 && <p class="muted">No alarm matches.</p>}
        <table class="all-alarms">
          <caption class="visually-hidden">All alarms</caption>
          <thead>
            <tr>
              <th scope="col">Alarm</th>
              <th scope="col">Priority</th>
              <th scope="col">State</th>
              <th scope="col">Condition</th>
              <td />
            </tr>
          </thead>
          <tbody>
            {shown.map((alarm) => (
              <Row alarm={alarm} takeOut={takeOut} key={alarm.name} />
            ))}
          </tbody>
        </table>
      </details>
    </section>
  )
}

function Row({ alarm, takeOut }: { alarm: Alarm; takeOut: (alarm: Alarm) => void }): JSX.Element {
  const { name, priority, state } = alarm
  const unit = useUnit()
  const mayTakeOut = hasRole(useSession(), 'engineer') && state !== 'out-of-service'
  return (
    <tr>
      <th scope="row">{name}</th>
      <td>
        <PriorityMark priority={priority} />
      </td>
      <td>
        <AlarmStateMark state={state} />
      </td>
      <td>{conditionText(alarm, unit)}</td>
      <td>
        {mayTakeOut && (
          <button type="button" aria-label={`Out of service: ${name}`} onClick={() => takeOut(alarm)}>
            Out of service …
          </button>
        )}
      </td>
    </tr>
  )
}
