// Webhooks and e-mails that are not delivered.

import type { Webhook } from '../api/types.ts'

/** chosen: a server that starts again answers within this time. */
const TOLERATED_MS = 60_000

/** Those with a notification that has not been delivered for longer than a minute: no user learns of an alarm that way. */
export const failingLong = (all: readonly Webhook[], now: number): Webhook[] =>
  all.filter(
    ({ problem, waiting, failing_since_ms }) =>
      problem !== null && waiting > 0 && now - (failing_since_ms ?? now) > TOLERATED_MS,
  )
