// The form for a new value of a parameter.

import './change-parameter.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import type { Parameter, Request } from '../../api/types.ts'
import { RiskMark } from '../../components/command-dialog.tsx'
import { useSnapshot } from '../../live.ts'
import { hasRole, useSession } from '../../session.ts'
import { t } from '../../texts/texts.ts'
import { ChangeButton } from './change-button.tsx'
import { obstacle } from './permission.ts'

type Write = NonNullable<Parameter['write']>

interface Props {
  parameter: Parameter
  open: (request: Request) => void
}

/** A button that opens the form; nothing if the parameter is not written, or if the role of the user does not allow it. */
export function ChangeParameter({ parameter, open }: Props): JSX.Element | null {
  const session = useSession()
  const control = useSnapshot().control_authority
  const [isEditing, setEditing] = useState(false)
  const { name, write } = parameter
  if (write === null || !hasRole(session, write.role)) return null
  if (write.blocked_reason !== null) {
    return (
      <details class="blocked">
        <summary>{t.gauge.blocked}</summary>
        {write.blocked_reason}
      </details>
    )
  }
  const reason = obstacle(session, control, write.role, null)
  if (isEditing && reason === null) {
    return <Form parameter={parameter} write={write} open={open} close={() => setEditing(false)} />
  }
  return (
    <ChangeButton label={t.gauge.changeOf(name)} reason={reason} press={() => setEditing(true)}>
      {t.gauge.change}
    </ChangeButton>
  )
}

function Form({ parameter, write, open, close }: Props & { write: Write; close: () => void }): JSX.Element {
  const { target, name, value } = parameter
  const submit = (event: JSX.TargetedSubmitEvent<HTMLFormElement>): void => {
    event.preventDefault()
    open({ target, value: String(new FormData(event.currentTarget).get('value') ?? '') })
    close()
  }
  const label = t.gauge.newValue(name)
  return (
    <form class="change" onSubmit={submit}>
      {write.allowed_values.length > 0 ? (
        <select name="value" aria-label={label} autofocus>
          {write.allowed_values.map((choice) => (
            <option value={choice} selected={choice === value} key={choice}>
              {choice}
            </option>
          ))}
        </select>
      ) : (
        <input name="value" aria-label={label} defaultValue={value ?? ''} autocomplete="off" required autofocus />
      )}
      <button type="submit" class="main">
        {t.gauge.arm}
      </button>
      <button type="button" onClick={close}>
        {t.common.cancel}
      </button>
      <span class="muted takes">
        <RiskMark risk={write.risk} /> {write.allowed_values.length === 0 && write.expects}
      </span>
    </form>
  )
}
