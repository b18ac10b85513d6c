// The commands of a gauge, with what they ask for and risk; and why one may not.

import type { JSX } from 'preact'
import { commands, pass, type Command, type Wish } from '../acting.ts'
import type { Gauge, Mastership, Role, Session } from '../api.ts'
import { useLive } from '../live.ts'
import { may, useSession } from '../session.ts'
import { moves, mastershipWords } from './mastership.tsx'
import { RiskMark } from './order.tsx'
import { useAsked } from './use.ts'

/** What is in the way of everything at once is told above all commands, and not again at each. */
const MASTERSHIP = 'needs the mastership'

/** Why somebody may not do something now; nothing if they may. */
export function obstacle(session: Session, mastership: Mastership, needed: Role, barred: string | null): string | null {
  if (barred) return barred
  if (!may(session, needed)) return `needs the role ${needed}`
  if (mastership.holder !== session.name) return MASTERSHIP
  return null
}

/** What is in the way of everything, and how to remove it. */
function Permission(): JSX.Element | null {
  const session = useSession()
  const { moment, now } = useLive()
  const { mastership } = moment!
  if (!may(session, 'operator')) {
    return <p class="muted permission">You may look. Commands need the role operator, parameters the role engineer.</p>
  }
  if (mastership.holder === session.name) return null
  const can = moves(mastership, session, now).find((move) => move === 'ask')
  return (
    <p class="muted permission">
      {mastershipWords(mastership, session)}. Only who has the mastership may act.{' '}
      {can && (
        <button type="button" onClick={() => void pass('ask').catch(() => {})}>
          Ask for it
        </button>
      )}
    </p>
  )
}

export function Commands({ gauge, begin }: { gauge: Gauge; begin: (wish: Wish) => void }): JSX.Element {
  const asked = useAsked(gauge.name, null, (signal) => commands(gauge.name, signal))
  // The manuals have one that does nothing in every block.
  const all = (asked.value ?? []).filter(({ command }) => !/[./]inactive$/.test(command))
  return (
    <section class="panel commands" aria-label="Commands">
      <div class="bar">
        <h2>Commands</h2>
      </div>
      <Permission />
      {asked.error && <p class="alarm">{asked.error}</p>}
      {asked.value && all.length === 0 && <p class="muted">The manual has none for this gauge.</p>}
      {all.length > 0 && (
        <ul>
          {all.map((command) => (
            <Row command={command} begin={begin} key={command.command} />
          ))}
        </ul>
      )}
    </section>
  )
}

function Row({ command, begin }: { command: Command; begin: (wish: Wish) => void }): JSX.Element {
  const session = useSession()
  const { mastership } = useLive().moment!
  const reason = obstacle(session, mastership, command.role, command.barred)
  const id = `why-${command.command}`
  return (
    <li data-command={command.command}>
      <button
        type="button"
        disabled={reason !== null}
        title={reason ?? undefined}
        aria-describedby={id}
        onClick={() => begin({ command: command.command })}
      >
        {command.command} …
      </button>
      <span class="command-facts" id={id}>
        <RiskMark risk={command.risk} /> {command.risk.class === 'dangerous' && command.risk.words}
        {command.conditions.length > 0 && <span class="muted"> Needs: {command.conditions.join('; ')}.</span>}
        {reason && reason !== MASTERSHIP && <em class="muted"> {reason}</em>}
      </span>
    </li>
  )
}
