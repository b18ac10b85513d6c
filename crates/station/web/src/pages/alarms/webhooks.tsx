// The delivery status of webhooks and e-mails.

import './webhooks.css'
import type { JSX } from 'preact'
import { fetchWebhooks } from '../../api/calls.ts'
import type { Webhook } from '../../api/types.ts'
import { useQuery } from '../../components/hooks.ts'
import { useLive } from '../../live.ts'
import { shortTime } from './item.tsx'

const REFRESH_MS = 2_000

const KINDS: Record<Webhook['kind'], string> = { webhook: 'webhook', email: 'e-mail' }

export function Webhooks(): JSX.Element | null {
  const { now } = useLive()
  const webhooks = useQuery('webhooks', REFRESH_MS, (signal) => fetchWebhooks(signal)).value ?? []
  if (webhooks.length === 0) return null
  return (
    <section class="panel" aria-label="Notifications">
      <h2>Notifications</h2>
      <ul class="webhooks">
        {webhooks.map((webhook) => (
          <li key={webhook.name} class={webhook.problem ? 'bad' : ''}>
            <strong>{webhook.name}</strong> {KINDS[webhook.kind]} <span class="muted">{webhook.at}</span>{' '}
            {status(webhook, now)}
          </li>
        ))}
      </ul>
    </section>
  )
}

function status(webhook: Webhook, now: number): string {
  const { waiting, given_up } = webhook
  const parts = [
    deliveryText(webhook, now),
    waiting > 0 ? `${waiting} queued` : '',
    given_up > 0 ? `${given_up} given up` : '',
  ]
  return parts.filter(Boolean).join(', ')
}

function deliveryText({ problem, failing_since_ms, waiting, delivered_ms }: Webhook, now: number): string {
  if (problem) return `failing since ${shortTime(failing_since_ms ?? now, now)}: ${problem}`
  if (delivered_ms !== null) return `last delivery ${shortTime(delivered_ms, now)}`
  return waiting > 0 ? 'first delivery under way' : 'nothing delivered yet'
}
