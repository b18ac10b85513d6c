// Texts whose numbers stay with their units on one line.

import './unbroken.css'
import type { JSX } from 'preact'
import { quantities } from '../lib/format.ts'

/** A text in which no line breaks within a quantity or a time. Its characters stay as they are: a name can be copied. */
export function Unbroken({ text }: { text: string }): JSX.Element {
  return (
    <>
      {quantities(text).map((part, index) =>
        index % 2 === 0 ? (
          part
        ) : (
          <span class="unbroken" key={index}>
            {part}
          </span>
        ),
      )}
    </>
  )
}
