// The default alarms, which every gauge, every segment or the station has, and the dialog in which an engineer changes one.

import './settings-dialog.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { changeDefaultAlarm, fetchDefaultAlarms } from '../../api/calls.ts'
import type { DefaultAlarm } from '../../api/types.ts'
import { FormEnd, ReasonField } from '../../components/form-dialog.tsx'
import { errorText, useModal, useQuery } from '../../components/hooks.ts'
import { QueryState } from '../../components/query-state.tsx'
import { Unbroken } from '../../components/unbroken.tsx'
import {
  about,
  changedDefault,
  type DefaultForm,
  defaultForm,
  effective,
  priorityText,
} from '../../lib/default-alarms.ts'
import { hasRole, useSession } from '../../session.ts'
import { t } from '../../texts/texts.ts'

const PRIORITIES = ['high', 'medium', 'low', 'off'] as const

/** Called after a change. */
interface Props {
  done: () => void
}

export function DefaultAlarms({ done }: Props): JSX.Element | null {
  const [changes, setChanges] = useState(0)
  const [chosen, setChosen] = useState<DefaultAlarm | null>(null)
  const query = useQuery(`default alarms ${changes}`, null, (signal) => fetchDefaultAlarms(signal))
  const mayChange = hasRole(useSession(), 'engineer')
  // A station without a file has none to change.
  if (query.value === null ? query.error === null : query.value.length === 0) return null
  return (
    <section class="panel" aria-label={t.defaultAlarms.title}>
      <details>
        <summary>
          <h2>{t.defaultAlarms.title}</h2>
        </summary>
        <QueryState of={[query]} />
        <table class="stacked">
          <caption class="visually-hidden">{t.defaultAlarms.title}</caption>
          <thead>
            <tr>
              <th scope="col">{t.defaultAlarms.name}</th>
              <th scope="col">{t.alarms.condition}</th>
              <th scope="col">{t.defaultAlarms.settings}</th>
              <td />
            </tr>
          </thead>
          <tbody>
            {query.value?.map((alarm) => (
              <tr key={alarm.name}>
                <th scope="row" lang="en">
                  {alarm.name}
                </th>
                <td>{about(alarm.name)}</td>
                <td data-title={t.defaultAlarms.settings}>
                  <Unbroken text={effective(alarm)} />
                </td>
                <td>
                  {mayChange && (
                    <button type="button" aria-label={t.alarmSettings.of(alarm.name)} onClick={() => setChosen(alarm)}>
                      {t.alarmSettings.button}
                    </button>
                  )}
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      </details>
      {chosen && (
        <DefaultAlarmDialog
          alarm={chosen}
          done={() => {
            setChanges((count) => count + 1)
            done()
          }}
          close={() => setChosen(null)}
        />
      )}
    </section>
  )
}

interface DialogProps extends Props {
  alarm: DefaultAlarm
  close: () => void
}

function DefaultAlarmDialog({ alarm, done, close }: DialogProps): JSX.Element {
  const { name, settings, defaults } = alarm
  const dialog = useModal()
  const [form, setForm] = useState<DefaultForm>(() => defaultForm(settings))
  const [reason, setReason] = useState('')
  const [error, setError] = useState<string | null>(null)
  const set = (key: keyof DefaultForm, text: string): void => setForm((before) => ({ ...before, [key]: text }))
  const submit = (event: Event): void => {
    event.preventDefault()
    setError(null)
    changeDefaultAlarm(name, settings, changedDefault(settings, form), reason)
      .then(() => {
        done()
        close()
      })
      .catch((error: unknown) => setError(errorText(error)))
  }
  const field = (key: keyof DefaultForm, label: string, placeholder: string | undefined): JSX.Element => (
    <label>
      {label}
      <input
        placeholder={placeholder}
        value={form[key]}
        pattern={key === 'limit' ? '[0-9.eE+\\-]*' : undefined}
        onInput={(event) => set(key, event.currentTarget.value)}
      />
    </label>
  )
  return (
    <dialog ref={dialog} onClose={close} aria-label={t.defaultAlarms.dialog} class="form-dialog settings-dialog">
      <h2>{t.alarmSettings.of(name)}</h2>
      <p>{about(name)}</p>
      <p class="muted">{t.defaultAlarms.apply}</p>
      <form onSubmit={submit}>
        <div class="pair">
          {field('delay', t.alarmSettings.delay, defaults.delay ?? undefined)}
          {field('off_delay', t.alarmSettings.offDelay, defaults.off_delay ?? undefined)}
          {defaults.limit != null && field('limit', t.defaultAlarms.limit, `${defaults.limit}`)}
          <label>
            {t.common.priority}
            <select value={form.priority} onChange={(event) => set('priority', event.currentTarget.value)}>
              <option value="">{t.defaultAlarms.default(priorityText(defaults.priority ?? 'medium'))}</option>
              {PRIORITIES.map((priority) => (
                <option value={priority} key={priority}>
                  {priorityText(priority)}
                </option>
              ))}
            </select>
          </label>
        </div>
        {!name.startsWith('database') && (
          <label>
            {name === 'segment' || name === 'damage' ? t.defaultAlarms.exceptSegments : t.defaultAlarms.exceptGauges}
            <textarea rows={3} value={form.except} onInput={(event) => set('except', event.currentTarget.value)} />
          </label>
        )}
        <ReasonField reason={reason} setReason={setReason} />
        <FormEnd submit={t.alarmSettings.submit} close={close} error={error} />
      </form>
    </dialog>
  )
}
