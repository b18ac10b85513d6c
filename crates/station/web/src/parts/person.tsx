// Who sits here, in the frame of all pages: name, role, log out, and a password of one's own.

import type { JSX } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'
import { changePassword, logout, useHere } from '../session.ts'
import { Password } from './password.tsx'
import { sentence } from './use.ts'

export function Person(): JSX.Element | null {
  const { session } = useHere()
  const [open, setOpen] = useState(false)
  const [error, setError] = useState<string | null>(null)
  if (!session || session.door === 'out') return null
  const who = (
    <>
      {session.name} <span class="muted">{session.role}</span>
    </>
  )
  if (session.door === 'open') return <span class="person">{who}</span>
  const leave = (): void => void logout().catch((error: unknown) => setError(sentence(error)))
  return (
    <>
      <button type="button" class="person" onClick={() => setOpen(true)} title="Your password">
        {who}
      </button>
      <button type="button" onClick={leave}>
        Log out
      </button>
      {error && (
        <span class="alarm" role="alert">
          {error}
        </span>
      )}
      {open && <Account name={session.name} close={() => setOpen(false)} />}
    </>
  )
}

function Account({ name, close }: { name: string; close: () => void }): JSX.Element {
  const dialog = useRef<HTMLDialogElement>(null)
  const form = useRef<HTMLFormElement>(null)
  const [error, setError] = useState<string | null>(null)
  const [done, setDone] = useState(false)
  useEffect(() => dialog.current?.showModal(), [])
  const field = (name: string): string => (form.current!.elements.namedItem(name) as HTMLInputElement).value
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault()
    setError(null)
    try {
      await changePassword(field('current'), field('new'))
      setDone(true)
    } catch (error) {
      setError(sentence(error))
    }
  }
  return (
    <dialog ref={dialog} onClose={close} aria-labelledby="account" class="account">
      <h2 id="account">A new password for {name}</h2>
      {done ? (
        <p role="status">It holds from now on. Your other windows and computers are logged out.</p>
      ) : (
        <form ref={form} method="post" onSubmit={(event) => void submit(event)}>
          <input
            class="unseen"
            name="username"
            autocomplete="username"
            value={name}
            readOnly
            tabIndex={-1}
            aria-hidden="true"
          />
          <p class="muted">At least 8 characters, better 15: some words that do not belong together.</p>
          {error && (
            <p class="alarm" role="alert">
              Nothing was changed: {error}.
            </p>
          )}
          <Password name="current" label="The one you have" autocomplete="current-password" />
          <Password name="new" label="The one you want" autocomplete="new-password" />
          <button type="submit" class="main">
            Change it
          </button>
        </form>
      )}
      <button type="button" onClick={close}>
        Close
      </button>
    </dialog>
  )
}
