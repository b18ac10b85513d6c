// The reasons why the user cannot send a command or write a parameter now.

import type { Control, Role, Session } from '../../api/types.ts'
import { hasRole } from '../../session.ts'

/** The commands panel says this once for all commands. */
export const NEEDS_CONTROL = 'needs control'

/** Why the user may not control the gauge; `null` if they may. `blocked` is the reason why no user may. */
export function obstacle(session: Session, control: Control, needed: Role, blocked: string | null): string | null {
  if (blocked) return blocked
  if (!hasRole(session, needed)) return `needs the role ${needed}`
  return control.holder === session.name ? null : NEEDS_CONTROL
}
