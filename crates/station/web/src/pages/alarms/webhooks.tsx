// The delivery status of webhooks and e-mails.

import './webhooks.css'
import type { JSX } from 'preact'
import { fetchWebhooks } from '../../api/calls.ts'
import type { Webhook } from '../../api/types.ts'
import { useQuery } from '../../components/hooks.ts'
import { useLive } from '../../live.ts'
import { t } from '../../texts/texts.ts'
import { shortTime } from './item.tsx'

const REFRESH_MS = 2_000

export function Webhooks(): JSX.Element | null {
  const { now } = useLive()
  const webhooks = useQuery('webhooks', REFRESH_MS, (signal) => fetchWebhooks(signal)).value ?? []
  if (webhooks.length === 0) return null
  return (
    <section class="panel" aria-label={t.notifications.title}>
      <h2>{t.notifications.title}</h2>
      <ul class="webhooks">
        {webhooks.map((webhook) => (
          <li key={webhook.name} class={webhook.problem ? 'bad' : ''}>
            <strong>{webhook.name}</strong> {t.notifications.kinds[webhook.kind]}{' '}
            <span class="muted">{webhook.at}</span> {status(webhook, now)}
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
    waiting > 0 ? t.notifications.queued(waiting) : '',
    given_up > 0 ? t.notifications.givenUp(given_up) : '',
  ]
  return parts.filter(Boolean).join(', ')
}

function deliveryText({ problem, failing_since_ms, waiting, delivered_ms }: Webhook, now: number): string {
  if (problem) return t.notifications.failing(shortTime(failing_since_ms ?? now, now), problem)
  if (delivered_ms !== null) return t.notifications.last(shortTime(delivered_ms, now))
  return waiting > 0 ? t.notifications.first : t.notifications.nothing
}
