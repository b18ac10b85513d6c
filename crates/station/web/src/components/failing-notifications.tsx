// A line of the overview about webhooks and e-mails that are not delivered.

import type { JSX } from 'preact'
import { fetchWebhooks } from '../api/calls.ts'
import { failingLong } from '../lib/notifications.ts'
import { useLive } from '../live.ts'
import { Link } from '../router.tsx'
import { t } from '../texts/texts.ts'
import { useQuery } from './hooks.ts'

const REFRESH_MS = 30_000

export function FailingNotifications(): JSX.Element | null {
  const { now } = useLive()
  const all = useQuery('webhooks', REFRESH_MS, (signal) => fetchWebhooks(signal)).value ?? []
  const failing = failingLong(all, now)
  if (failing.length === 0) return null
  return (
    <p class="error" role="status">
      <Link to="/alarms">{t.notifications.failingLong(failing.map(({ name }) => name).join(', '))}</Link>
    </p>
  )
}
