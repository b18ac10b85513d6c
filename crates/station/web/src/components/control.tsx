// Control of the gauges, in the header of every page: the user who has it, and the buttons to request and hand it over.

import './control.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { changeControl } from '../api/calls.ts'
import type { Control, ControlAction, Session } from '../api/types.ts'
import { hasRole, useSession } from '../session.ts'
import { t } from '../texts/texts.ts'
import { errorText } from './hooks.ts'

/** After this long without an answer, an operator who has requested control can take it. */
const ANSWER_MS = 60_000

/** The actions that the user has now. */
export function controlActions(control: Control, session: Session, now: number): ControlAction[] {
  const { holder, requested_by, requested_ms } = control
  if (!hasRole(session, 'operator')) return []
  if (holder === null) return ['request']
  if (holder === session.name) return requested_by === null ? ['release'] : ['grant', 'release']
  const hasWaited = requested_by === session.name && requested_ms !== null && now - requested_ms >= ANSWER_MS
  const take: ControlAction[] = hasRole(session, 'engineer') || hasWaited ? ['take-over'] : []
  return requested_by === null ? ['request', ...take] : take
}

/** `Otto has control`. */
export function controlText({ holder, requested_by }: Control, { name }: Session): string {
  if (holder === null) return t.control.noOne
  const has = holder === name ? t.control.own : t.control.other(holder)
  if (requested_by === null) return has
  return requested_by === name ? t.control.ownRequest(has) : t.control.request(has, requested_by)
}

interface Props {
  control: Control
  now: number
  /** Without a connection no request reaches the station. */
  connected: boolean
}

export function ControlStatus({ control, now, connected }: Props): JSX.Element {
  const session = useSession()
  const [error, setError] = useState<string | null>(null)
  const run = (action: ControlAction): void => {
    setError(null)
    changeControl(action).catch((error: unknown) => setError(errorText(error)))
  }
  const isOwn = control.holder !== null && control.holder === session.name
  return (
    // biome-ignore lint/a11y/useSemanticElements: a fieldset is for fields
    <div class={isOwn ? 'control own' : 'control'} aria-label={t.control.title} role="group">
      <span role="status" class={control.holder === null ? 'free' : undefined}>
        {controlText(control, session)}
      </span>
      {controlActions(control, session, now).map((action) => (
        <button
          type="button"
          class={action === 'grant' ? 'main' : undefined}
          key={action}
          disabled={!connected}
          title={connected ? t.control.actions[action].title : t.control.noConnection}
          onClick={() => run(action)}
        >
          {t.control.actions[action].label}
        </button>
      ))}
      {error && (
        <span class="refusal" role="alert">
          {error}
        </span>
      )}
    </div>
  )
}
