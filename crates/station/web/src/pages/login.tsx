// Who are you? Instead of any page, which stays in the address and comes back afterwards.

import type { JSX } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'
import { Password } from '../parts/password.tsx'
import { sentence } from '../parts/use.ts'
import { login, useHere } from '../session.ts'

export function Login(): JSX.Element {
  const { lost } = useHere()
  const [error, setError] = useState<string | null>(null)
  const [busy, setBusy] = useState(false)
  const form = useRef<HTMLFormElement>(null)
  const field = (name: string): HTMLInputElement => form.current!.elements.namedItem(name) as HTMLInputElement
  useEffect(() => field(lost ? 'password' : 'username').focus(), [])
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault()
    setBusy(true)
    setError(null)
    try {
      await login(field('username').value.trim(), field('password').value)
    } catch (error) {
      setError(sentence(error))
      setBusy(false)
      field('password').select()
    }
  }
  return (
    <section class="panel login" aria-labelledby="login">
      <h1 id="login">Log in</h1>
      {lost && (
        <p class="notice" role="status">
          Your session has ended. Log in again, and you are back where you were.
        </p>
      )}
      {error && (
        <p class="alarm" role="alert">
          Not logged in: {error}.
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
            defaultValue={lost ?? ''}
          />
        </label>
        <Password name="password" label="Password" autocomplete="current-password" />
        <button type="submit" class="main" disabled={busy}>
          {busy ? 'Logging in …' : 'Log in'}
        </button>
      </form>
      <p class="muted">
        Whoever runs the station makes users, with <code>profivac user add</code>.
      </p>
    </section>
  )
}
