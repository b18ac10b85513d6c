// The user in the header of all pages: name, role, logout, change of password.

import './account-menu.css'
import type { JSX } from 'preact'
import { useRef, useState } from 'preact/hooks'
import { changePassword, logout, useSessionState } from '../session.ts'
import { errorText, useModal } from './hooks.ts'
import { PasswordField } from './password-field.tsx'

export function AccountMenu(): JSX.Element | null {
  const { session } = useSessionState()
  const [open, setOpen] = useState(false)
  const [error, setError] = useState<string | null>(null)
  if (!session || session.login === 'logged-out') return null
  const user = (
    <>
      {session.name} <span class="muted">{session.role}</span>
    </>
  )
  if (session.login === 'not-required') return <span class="user">{user}</span>
  const leave = (): void => void logout().catch((error: unknown) => setError(errorText(error)))
  return (
    <>
      <button type="button" class="user" onClick={() => setOpen(true)} title="Change password">
        {user}
      </button>
      <button type="button" onClick={leave}>
        Log out
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
      <h2 id="password-title">Change the password of {name}</h2>
      {done ? (
        <p role="status">The password is changed. Your other windows and computers are logged out.</p>
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
          <p class="muted">At least 8 characters, better 15: a few words that do not belong together.</p>
          {error && (
            <p class="error" role="alert">
              The password is not changed: {error}.
            </p>
          )}
          <PasswordField name="current" label="Current password" autocomplete="current-password" />
          <PasswordField name="new" label="New password" autocomplete="new-password" />
          <button type="submit" class="main">
            Change password
          </button>
        </form>
      )}
      <button type="button" onClick={close}>
        Close
      </button>
    </dialog>
  )
}
