// A field for a password, which can be shown to whoever types it.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'

export function Password({
  name,
  label,
  autocomplete,
}: {
  name: string
  label: string
  autocomplete: 'current-password' | 'new-password'
}): JSX.Element {
  const [shown, setShown] = useState(false)
  return (
    <div class="secret">
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
      <button type="button" aria-pressed={shown} aria-label={`Show: ${label}`} onClick={() => setShown(!shown)}>
        Show
      </button>
    </div>
  )
}
