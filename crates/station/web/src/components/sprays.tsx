// Changes of an indication that look like helium at a leak, in words.

import type { JSX } from 'preact'
import type { Spray } from '../api/types.ts'
import { readable } from '../lib/format.ts'
import { t } from '../texts/texts.ts'

export function Sprays({ sprays }: { sprays: Spray[] }): JSX.Element | null {
  if (sprays.length === 0) return null
  return (
    <section class="sprays" aria-label={t.reading.likeHelium}>
      {sprays.map(({ start_ms, text }) => (
        <p key={start_ms} lang="en">
          {readable(text)}.
        </p>
      ))}
    </section>
  )
}
