// A part of a page that is closed at first, and drawn while it is open.

import type { ComponentChildren, JSX } from 'preact'
import { useState } from 'preact/hooks'

interface Props {
  title: string
  draw: () => ComponentChildren
}

export function ClosedPart({ title, draw }: Props): JSX.Element {
  const [open, setOpen] = useState(false)
  return (
    <details open={open} onToggle={({ currentTarget }) => setOpen(currentTarget.open)}>
      <summary>
        <h2>{title}</h2>
      </summary>
      {open && draw()}
    </details>
  )
}
