// What a station is to us, as a mark and a word: colour alone says nothing to one man in twelve.

import type { JSX } from 'preact'
import type { Standing } from '../api.ts'
import { STANDINGS } from '../pure/words.ts'

export function StandingMark({ standing, old = false }: { standing: Standing; old?: boolean }): JSX.Element {
  return (
    <span class={`standing ${old ? 'old' : standing}`} title={STANDINGS[standing].sentence}>
      <span class="dot" aria-hidden="true" />
      {STANDINGS[standing].word}
    </span>
  )
}
