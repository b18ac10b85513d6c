// All configured alarms, whether active or not.

import './all.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import type { Alarm } from '../../api/types.ts'
import { AlarmStateMark, PriorityMark } from '../../components/alarm-marks.tsx'
import { ClosedPart } from '../../components/closed-part.tsx'
import { SearchField } from '../../components/fields.tsx'
import type { Query } from '../../components/hooks.ts'
import { QueryState } from '../../components/query-state.tsx'
import { Unbroken } from '../../components/unbroken.tsx'
import { conditionText, isActive } from '../../lib/alarms.ts'
import { hasRole, useSession } from '../../session.ts'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'
import { SettingsButton } from './settings-dialog.tsx'
import type { Suppress } from './suppress-dialog.tsx'

interface Props {
  query: Query<Alarm[]>
  suppress: (suppress: Suppress) => void
  edit: (alarm: Alarm) => void
}

export function AllAlarms(props: Props): JSX.Element {
  return (
    <section class="panel" aria-label={t.alarms.all}>
      <ClosedPart title={t.alarms.allOf(props.query.value?.length ?? 0)} draw={() => <Table {...props} />} />
    </section>
  )
}

function Table({ query, suppress, edit }: Props): JSX.Element {
  const unit = useUnit()
  const [text, setText] = useState('')
  const alarms = query.value ?? []
  const shown = alarms.filter((alarm) =>
    `${alarm.name} ${conditionText(alarm, unit)}`.toLowerCase().includes(text.toLowerCase()),
  )
  const mayShelve = hasRole(useSession(), 'operator')
  const shelvable = shown.filter(mayBeShelved)
  return (
    <>
      <div class="bar">
        <SearchField label={t.alarms.search} value={text} onInput={setText} />
        {mayShelve && text !== '' && shelvable.length > 1 && (
          <button type="button" onClick={() => suppress({ kind: 'shelve', alarms: shelvable })}>
            {t.alarms.shelveThese(shelvable.length)}
          </button>
        )}
      </div>
      <QueryState of={[query]} empty={alarms.length > 0 && shown.length === 0 && t.alarms.noMatch} />
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
    </>
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
