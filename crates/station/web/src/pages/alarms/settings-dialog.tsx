// The dialog in which an engineer changes the limit, the delays and the priority of an alarm.

import './settings-dialog.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { changeAlarmSettings, fetchAlarmSettings } from '../../api/calls.ts'
import type { Alarm, AlarmSettings } from '../../api/types.ts'
import { FormEnd, ReasonField } from '../../components/form-dialog.tsx'
import { errorText, useModal, useQuery } from '../../components/hooks.ts'
import {
  changed,
  FIELDS,
  type Field,
  formOf,
  hasReset,
  hasSettings,
  resetOf,
  type SettingsForm,
} from '../../lib/alarm-settings.ts'
import { hasRole, useSession } from '../../session.ts'
import { t } from '../../texts/texts.ts'
import { SettingsValues } from './settings-values.tsx'

const priorities = (): [string, string][] => [['', t.alarmSettings.defaultPriority], ...Object.entries(t.priorities)]

/** The button that opens the dialog, for alarms that the file of the station lists. */
export function SettingsButton({ alarm, open }: { alarm: Alarm; open: (alarm: Alarm) => void }): JSX.Element | null {
  if (!hasRole(useSession(), 'engineer') || !hasSettings(alarm)) return null
  return (
    <button type="button" class="settings" aria-label={t.alarmSettings.of(alarm.name)} onClick={() => open(alarm)}>
      {t.alarmSettings.button}
    </button>
  )
}

interface Props {
  alarm: Alarm
  /** Called after a change. */
  done: () => void
  close: () => void
}

export function SettingsDialog({ alarm, done, close }: Props): JSX.Element {
  const { name } = alarm
  const dialog = useModal()
  const { value, error } = useQuery(`settings ${name}`, null, (signal) => fetchAlarmSettings(name, signal))
  return (
    <dialog ref={dialog} onClose={close} aria-label={t.alarmSettings.title} class="form-dialog settings-dialog">
      <h2>{t.alarmSettings.of(name)}</h2>
      <p class="muted">{t.alarmSettings.apply}</p>
      {error && (
        <p class="error" role="alert">
          {error}
        </p>
      )}
      {value && <Form alarm={alarm} seen={value} done={done} close={close} />}
      {!value && (
        <div class="buttons">
          <button type="button" onClick={close}>
            {t.common.cancel}
          </button>
        </div>
      )}
    </dialog>
  )
}

function Form({ alarm, seen, done, close }: Props & { seen: AlarmSettings }): JSX.Element {
  const [form, setForm] = useState<SettingsForm>(() => formOf(seen))
  const [reason, setReason] = useState('')
  const [error, setError] = useState<string | null>(null)
  const set = (key: Field['key'], text: string): void => setForm((before) => ({ ...before, [key]: text }))
  const submit = (event: Event): void => {
    event.preventDefault()
    setError(null)
    changeAlarmSettings(alarm.name, seen, changed(seen, form), reason)
      .then(() => {
        done()
        close()
      })
      .catch((error: unknown) => setError(errorText(error)))
  }
  return (
    <form onSubmit={submit}>
      {hasReset(seen) && <SettingsValues alarm={alarm} reset={resetOf(form)} />}
      <div class="pair">
        {FIELDS.filter(({ shown }) => shown(seen)).map(({ key, label, placeholder, isNumber, isLimit }) => (
          <label key={key}>
            {label()}
            <input
              required={isLimit}
              placeholder={placeholder?.()}
              inputMode={isNumber ? 'decimal' : 'text'}
              pattern={isNumber ? '[0-9.eE+\\-]*' : '.*'}
              value={form[key]}
              onInput={(event) => set(key, event.currentTarget.value)}
            />
          </label>
        ))}
        <label>
          {t.common.priority}
          <select value={form.priority} onChange={(event) => set('priority', event.currentTarget.value)}>
            {priorities().map(([value, text]) => (
              <option value={value} key={value}>
                {text}
              </option>
            ))}
          </select>
        </label>
      </div>
      <ReasonField reason={reason} setReason={setReason} />
      <FormEnd submit={t.alarmSettings.submit} close={close} error={error} />
    </form>
  )
}
