// The login page. It replaces any other page, whose address stays and is shown after the login.

import './login.css'
import type { JSX } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'
import { errorText } from '../components/hooks.ts'
import { PasswordField } from '../components/password-field.tsx'
import { login, useSessionState } from '../session.ts'
import { t } from '../texts/texts.ts'

export function Login(): JSX.Element {
  const { expiredUser } = useSessionState()
  const [error, setError] = useState<string | null>(null)
  const [busy, setBusy] = useState(false)
  const form = useRef<HTMLFormElement>(null)
  const field = (name: string): HTMLInputElement | null | undefined =>
    form.current?.querySelector(`input[name=${name}]`)
  useEffect(() => field(expiredUser ? 'password' : 'username')?.focus(), [])
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault()
    setBusy(true)
    setError(null)
    try {
      await login(field('username')?.value.trim() ?? '', field('password')?.value ?? '')
    } catch (error) {
      setError(errorText(error))
      setBusy(false)
      field('password')?.select()
    }
  }
  return (
    <section class="panel login" aria-labelledby="login">
      <h1 id="login">{t.login.title}</h1>
      {expiredUser && (
        <p class="notice" role="status">
          {t.login.expired}
        </p>
      )}
      {error && (
        <p class="error" role="alert">
          {t.login.failed(error)}
        </p>
      )}
      <form ref={form} method="post" onSubmit={(event) => void submit(event)}>
        <label>
          <span>{t.login.name}</span>
          <input
            name="username"
            autocomplete="username"
            autocapitalize="none"
            spellcheck={false}
            required
            defaultValue={expiredUser ?? ''}
          />
        </label>
        <PasswordField name="password" label={t.login.password} autocomplete="current-password" />
        <button type="submit" class="main" disabled={busy}>
          {busy ? t.login.busy : t.login.submit}
        </button>
      </form>
      <p class="muted">{t.login.users(<code>profivac user add</code>)}</p>
    </section>
  )
}
