// The login page. It replaces any other page, whose address stays and is shown after the login.

import './login.css'
import type { JSX } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'
import { errorText } from '../components/hooks.ts'
import { PasswordField } from '../components/password-field.tsx'
import { login, loginAtProvider, useSessionState } from '../session.ts'
import { t } from '../texts/texts.ts'

export function Login(): JSX.Element {
  const { session, expiredUser, loginError } = useSessionState()
  const provider = session?.provider
  const [failed, setFailed] = useState<string | null>(null)
  const [tried, setTried] = useState(false)
  const error = failed ?? (tried ? null : loginError)
  const [busy, setBusy] = useState(false)
  const form = useRef<HTMLFormElement>(null)
  const field = (name: string): HTMLInputElement | null | undefined =>
    form.current?.querySelector(`input[name=${name}]`)
  useEffect(() => {
    const button = form.current?.parentElement?.querySelector<HTMLElement>('.provider button')
    const first = button ?? field(expiredUser ? 'password' : 'username')
    first?.focus()
    // The browser may show this page again as it was when it left for the provider.
    const shown = (): void => setBusy(false)
    addEventListener('pageshow', shown)
    return () => removeEventListener('pageshow', shown)
  }, [])
  /** Whether the step has succeeded. */
  const attempt = async (step: () => Promise<void>): Promise<boolean> => {
    setBusy(true)
    setTried(true)
    setFailed(null)
    try {
      await step()
      return true
    } catch (error) {
      setFailed(errorText(error))
      setBusy(false)
      return false
    }
  }
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault()
    const step = () => login(field('username')?.value.trim() ?? '', field('password')?.value ?? '')
    if (!(await attempt(step))) field('password')?.select()
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
      {provider && (
        <div class="provider">
          <button type="button" class="main" disabled={busy} onClick={() => void attempt(loginAtProvider)}>
            {t.login.provider(provider)}
          </button>
          <p class="muted">{t.login.orPassword}</p>
        </div>
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
            defaultValue={expiredUser?.startsWith('openid:') ? '' : (expiredUser ?? '')}
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
