// A password field whose text can be shown.

import './password-field.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { t } from '../texts/texts.ts'

interface Props {
  name: string
  label: string
  autocomplete: 'current-password' | 'new-password'
}

export function PasswordField({ name, label, autocomplete }: Props): JSX.Element {
  const [shown, setShown] = useState(false)
  return (
    <div class="password-field">
      <label>
        <span>{label}</span>
        <input
          name={name}
          type={shown ? 'text' : 'password'}
          autocomplete={autocomplete}
          autocapitalize="none"
          spellcheck={false}
          required
        />
      </label>
      <button type="button" aria-pressed={shown} aria-label={t.account.showOf(label)} onClick={() => setShown(!shown)}>
        {t.account.show}
      </button>
    </div>
  )
}
