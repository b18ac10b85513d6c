// The login page. It replaces any other page, whose address stays and is shown after the login.

import './login.css'
import type { JSX } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'
import { errorText } from '../components/hooks.ts'
import { PasswordField } from '../components/password-field.tsx'
import { login, useSessionState } from '../session.ts'

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
      <h1 id="login">Log in</h1>
      {expiredUser && (
        <p class="notice" role="status">
          Your session has ended. Log in again to return to this page.
        </p>
      )}
      {error && (
        <p class="error" role="alert">
          Login failed: {error}.
        </p>
      )}
      <form ref={form} method="post" onSubmit={(event) => void submit(event)}>
        <label>
          <span>Name</span>
          <input
            name="username"
            autocomplete="username"
            autocapitalize="none"
            spellcheck={false}
            required
            defaultValue={expiredUser ?? ''}
          />
        </label>
        <PasswordField name="password" label="Password" autocomplete="current-password" />
        <button type="submit" class="main" disabled={busy}>
          {busy ? 'Logging in …' : 'Log in'}
        </button>
      </form>
      <p class="muted">
        Users are created on the station with <code>profivac user add</code>.
      </p>
    </section>
  )
}
