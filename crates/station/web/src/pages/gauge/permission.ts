// The reasons why the user cannot send a command or write a parameter now.

import type { Control, Role, Session } from '../../api/types.ts'
import { live } from '../../live.ts'
import { hasRole } from '../../session.ts'
import { t } from '../../texts/texts.ts'

/** Why the user may not control the gauge; `null` if they may. `blocked` is the reason why no user may. */
export function obstacle(session: Session, control: Control, needed: Role, blocked: string | null): string | null {
  if (!live().connected) return t.control.noConnection
  if (blocked) return blocked
  if (!hasRole(session, needed)) return t.control.needsRole(t.roles[needed])
  return control.holder === session.name ? null : t.control.needsControl
}
