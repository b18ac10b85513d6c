// Webhooks and e-mails that are not delivered.

import type { Webhook } from '../api/types.ts'

/** free choice: a server that starts again answers within this time. */
const TOLERATED_MS = 60_000

/** Those that have failed for longer than a moment: no user learns of an alarm that way. */
export const failingLong = (all: readonly Webhook[], now: number): Webhook[] =>
  all.filter(({ problem, failing_since_ms }) => problem !== null && now - (failing_since_ms ?? now) > TOLERATED_MS)
