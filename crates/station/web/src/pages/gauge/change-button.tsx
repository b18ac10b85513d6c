// The button that begins the change of a parameter.

import type { JSX } from 'preact'

interface Props {
  /** The parameter in words, for readers of the screen. */
  label: string
  children: string
  /** Why the user cannot press it at present; `null` if the user can. */
  reason: string | null
  press: () => void
}

export function ChangeButton({ label, children, reason, press }: Props): JSX.Element {
  return (
    <button
      type="button"
      class="change"
      disabled={reason !== null}
      title={reason ?? undefined}
      aria-label={label}
      onClick={press}
    >
      {children}
    </button>
  )
}
