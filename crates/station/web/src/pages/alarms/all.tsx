// All configured alarms, whether active or not.

import './all.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import type { Alarm } from '../../api/types.ts'
import { AlarmStateMark, PriorityMark } from '../../components/alarm-marks.tsx'
import { SearchField } from '../../components/fields.tsx'
import { Unbroken } from '../../components/unbroken.tsx'
import { conditionText, isActive } from '../../lib/alarms.ts'
import { hasRole, useSession } from '../../session.ts'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'
import { SettingsButton } from './settings-dialog.tsx'
import type { Suppress } from './suppress-dialog.tsx'

interface Props {
  alarms: Alarm[]
  isLoaded: boolean
  error: string | null
  suppress: (suppress: Suppress) => void
  edit: (alarm: Alarm) => void
}

export function AllAlarms({ alarms, isLoaded, error, suppress, edit }: Props): JSX.Element {
  const unit = useUnit()
  const [text, setText] = useState('')
  const shown = alarms.filter((alarm) =>
    `${alarm.name} ${conditionText(alarm, unit)}`.toLowerCase().includes(text.toLowerCase()),
  )
  const mayShelve = hasRole(useSession(), 'operator')
  const shelvable = shown.filter(mayBeShelved)
  return (
    <section class="panel" aria-label={t.alarms.all}>
      <details>
        <summary>
          <h2>{t.alarms.allOf(alarms.length)}</h2>
        </summary>
        <div class="bar">
          <SearchField label={t.alarms.search} value={text} onInput={setText} />
          {mayShelve && text !== '' && shelvable.length > 1 && (
            <button type="button" onClick={() => suppress({ kind: 'shelve', alarms: shelvable })}>
              {t.alarms.shelveThese(shelvable.length)}
            </button>
          )}
        </div>
        {error && <p class="error">{error}</p>}
        {!isLoaded && !error && <p class="muted">{t.log.loading}</p>}
        {alarms.length > 0 && shown.length === 0 && <p class="muted">{t.alarms.noMatch}</p>}
        <table class="all-alarms">
          <caption class="visually-hidden">{t.alarms.all}</caption>
          <thead>
            <tr>
              <th scope="col">{t.common.alarm}</th>
              <th scope="col">{t.common.priority}</th>
              <th scope="col">{t.common.state}</th>
              <th scope="col">{t.alarms.condition}</th>
              <td />
            </tr>
          </thead>
          <tbody>
            {shown.map((alarm) => (
              <Row alarm={alarm} suppress={suppress} edit={edit} key={alarm.name} />
            ))}
          </tbody>
        </table>
      </details>
    </section>
  )
}

const mayBeShelved = ({ state }: Alarm): boolean => state !== 'shelved' && state !== 'out-of-service'

function Row({ alarm, suppress, edit }: Pick<Props, 'suppress' | 'edit'> & { alarm: Alarm }): JSX.Element {
  const { name, priority, state } = alarm
  const unit = useUnit()
  const session = useSession()
  const mayTakeOut = hasRole(session, 'engineer') && state !== 'out-of-service'
  return (
    <tr>
      <th scope="row">
        <Unbroken text={name} />
      </th>
      <td>
        <PriorityMark priority={priority} active={isActive({ state })} />
      </td>
      <td>
        <AlarmStateMark state={state} />
      </td>
      <td>
        <Unbroken text={conditionText(alarm, unit)} />
      </td>
      <td>
        {hasRole(session, 'operator') && mayBeShelved(alarm) && (
          <button
            type="button"
            aria-label={t.alarms.shelveOf(name)}
            onClick={() => suppress({ kind: 'shelve', alarms: [alarm] })}
          >
            {t.alarms.shelve}
          </button>
        )}
        {mayTakeOut && (
          <button
            type="button"
            aria-label={t.alarms.outOfServiceOf(name)}
            onClick={() => suppress({ kind: 'out-of-service', alarms: [alarm] })}
          >
            {t.alarms.outOfService}
          </button>
        )}
        <SettingsButton alarm={alarm} open={edit} />
      </td>
    </tr>
  )
}
