// Who may act: in the header of every page.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { pass, type Move } from '../acting.ts'
import type { Mastership, Session } from '../api.ts'
import { may, useSession } from '../session.ts'
import { sentence } from './use.ts'

/** A holder who has not reacted for so long can be relieved by who asked. */
const REACTION_MS = 60_000

/** What somebody can do with the mastership as it is. */
export function moves(mastership: Mastership, session: Session, now: number): Move[] {
  const { holder, asked_by, asked_ms } = mastership
  if (!may(session, 'operator')) return []
  if (holder === null) return ['ask']
  if (holder === session.name) return asked_by === null ? ['release'] : ['grant', 'release']
  const waited = asked_by === session.name && asked_ms !== null && now - asked_ms >= REACTION_MS
  const takes: Move[] = may(session, 'engineer') || waited ? ['take-over'] : []
  return asked_by === null ? ['ask', ...takes] : takes
}

const WORDS: Record<Move, string> = { ask: 'Ask', release: 'Release', grant: 'Grant', 'take-over': 'Take over' }

const MEANINGS: Record<Move, string> = {
  ask: 'Ask for the mastership: only who has it may act on gauges',
  release: 'Give the mastership back',
  grant: 'Give the mastership to who asked',
  'take-over': 'Take the mastership: what its holder has armed is disarmed',
}

/** Who has it, in words. */
export function mastershipWords({ holder, asked_by }: Mastership, { name }: Session): string {
  if (holder === null) return 'Nobody acts'
  if (holder === name) return asked_by === null ? 'You act' : `You act, ${asked_by} asks`
  if (asked_by === null) return `${holder} acts`
  return asked_by === name ? `${holder} acts, you have asked` : `${holder} acts, ${asked_by} asks`
}

export function MastershipMark({ mastership, now }: { mastership: Mastership; now: number }): JSX.Element {
  const session = useSession()
  const [refused, setRefused] = useState<string | null>(null)
  const move = (wanted: Move): void => {
    setRefused(null)
    pass(wanted).catch((error: unknown) => setRefused(sentence(error)))
  }
  const mine = mastership.holder !== null && mastership.holder === session.name
  return (
    <div class={mine ? 'mastership mine' : 'mastership'} aria-label="Mastership" role="group">
      <span role="status">{mastershipWords(mastership, session)}</span>
      {moves(mastership, session, now).map((wanted) => (
        <button
          type="button"
          class={wanted === 'grant' ? 'main' : undefined}
          key={wanted}
          title={MEANINGS[wanted]}
          onClick={() => move(wanted)}
        >
          {WORDS[wanted]}
        </button>
      ))}
      {refused && (
        <span class="refusal" role="alert">
          {refused}
        </span>
      )}
    </div>
  )
}
