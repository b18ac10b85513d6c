// A list of which the first few are seen at once, and the others after a click.

import type { JSX } from 'preact'
import { t } from '../texts/texts.ts'

/** That many lines leave room in a dialog for its fields. */
const FEW = 8

interface Props<T> {
  items: T[]
  /** Draws a part of the list. */
  draw: (items: T[]) => JSX.Element
}

export function FirstFew<T>({ items, draw }: Props<T>): JSX.Element {
  const others = items.slice(FEW)
  return (
    <>
      {draw(items.slice(0, FEW))}
      {others.length > 0 && (
        <details>
          <summary>{t.common.andMore(others.length)}</summary>
          {draw(others)}
        </details>
      )}
    </>
  )
}
