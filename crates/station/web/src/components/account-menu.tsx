// The user in the header of all pages: name, role, logout, change of password.

import './account-menu.css'
import type { JSX } from 'preact'
import { useRef, useState } from 'preact/hooks'
import { changePassword, logout, useSessionState } from '../session.ts'
import { t } from '../texts/texts.ts'
import { errorText, useModal } from './hooks.ts'
import { PasswordField } from './password-field.tsx'

export function AccountMenu(): JSX.Element | null {
  const { session } = useSessionState()
  const [open, setOpen] = useState(false)
  const [error, setError] = useState<string | null>(null)
  if (!session || session.login === 'logged-out') return null
  const user = (
    <>
      {session.name} <span class="muted">{t.roles[session.role]}</span>
    </>
  )
  if (session.login === 'not-required') return <span class="user">{user}</span>
  const leave = (): void => void logout().catch((error: unknown) => setError(errorText(error)))
  return (
    <>
      {session.has_password ? (
        <button type="button" class="user" onClick={() => setOpen(true)} title={t.account.change}>
          {user}
        </button>
      ) : (
        <span class="user">{user}</span>
      )}
      <button type="button" onClick={leave}>
        {t.account.logOut}
      </button>
      {error && (
        <span class="error" role="alert">
          {error}
        </span>
      )}
      {open && <PasswordDialog name={session.name} close={() => setOpen(false)} />}
    </>
  )
}

function PasswordDialog({ name, close }: { name: string; close: () => void }): JSX.Element {
  const dialog = useModal()
  const form = useRef<HTMLFormElement>(null)
  const [error, setError] = useState<string | null>(null)
  const [done, setDone] = useState(false)
  const field = (name: string): string => String(new FormData(form.current ?? undefined).get(name) ?? '')
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault()
    setError(null)
    try {
      await changePassword(field('current'), field('new'))
      setDone(true)
    } catch (error) {
      setError(errorText(error))
    }
  }
  return (
    <dialog ref={dialog} onClose={close} aria-labelledby="password-title" class="password-dialog">
      <h2 id="password-title">{t.account.title(name)}</h2>
      {done ? (
        <p role="status">{t.account.changed}</p>
      ) : (
        <form ref={form} method="post" onSubmit={(event) => void submit(event)}>
          {/* For the password manager. */}
          <input
            class="visually-hidden"
            name="username"
            autocomplete="username"
            value={name}
            readOnly
            tabIndex={-1}
            aria-hidden="true"
          />
          <p class="muted">{t.account.advice}</p>
          {error && (
            <p class="error" role="alert">
              {t.account.notChanged(error)}
            </p>
          )}
          <PasswordField name="current" label={t.account.current} autocomplete="current-password" />
          <PasswordField name="new" label={t.account.new} autocomplete="new-password" />
          <button type="submit" class="main">
            {t.account.change}
          </button>
        </form>
      )}
      <button type="button" onClick={close}>
        {t.common.close}
      </button>
    </dialog>
  )
}
