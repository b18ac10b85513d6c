// The commands of a gauge, with their conditions and risks.

import './commands.css'
import type { JSX } from 'preact'
import { changeControl, fetchCommands } from '../../api/calls.ts'
import type { Command, Gauge, Request } from '../../api/types.ts'
import { DeviceFileMark, RiskMark, RiskText } from '../../components/command-dialog.tsx'
import { controlActions, controlText } from '../../components/control.tsx'
import { useQuery } from '../../components/hooks.ts'
import { QueryState } from '../../components/query-state.tsx'
import { commandWords, inUse, operatingStates } from '../../lib/commands.ts'
import { clock, readable } from '../../lib/format.ts'
import { useLive, useSnapshot } from '../../live.ts'
import { hasRole, useSession } from '../../session.ts'
import { t } from '../../texts/texts.ts'
import type { Read } from './parameters.tsx'
import { obstacle } from './permission.ts'

interface Props {
  gauge: Gauge
  open: (request: Request) => void
  /** The parameters, as they were read last. */
  read: Read
}

export function Commands({ gauge, open, read }: Props): JSX.Element {
  const query = useQuery(gauge.name, null, (signal) => fetchCommands(gauge.name, signal))
  const { parts, device } = inUse(query.value ?? [])
  const all = [...parts, ...device]
  const list = (commands: Command[]): JSX.Element => (
    <ul>
      {commands.map((command) => (
        <Item command={command} words={commandWords(command.command, all)} open={open} key={command.command} />
      ))}
    </ul>
  )
  return (
    <section class="panel commands" aria-label={t.gauge.commands}>
      <div class="bar">
        <h2>{t.gauge.commands}</h2>
      </div>
      <States gauge={gauge} read={read} />
      <Permission />
      <QueryState of={[query]} empty={all.length === 0 && t.gauge.noCommands} />
      {parts.length > 0 && list(parts)}
      {device.length > 0 && (
        <details open={parts.length === 0}>
          <summary>{t.gauge.deviceCommands}</summary>
          {list(device)}
        </details>
      )}
    </section>
  )
}

/** Emission and degas, and when they were read. */
function States({ gauge, read }: Pick<Props, 'gauge' | 'read'>): JSX.Element | null {
  const states = operatingStates(gauge, read.blocks)
  if (states.length === 0) return null
  return (
    <p class="operating-states" role="status">
      {states.map(({ target, name, text }) => (
        <span key={target} data-state={target}>
          <span lang="en" class="muted">
            {name}
          </span>{' '}
          <strong lang="en">{readable(text)}</strong>
        </span>
      ))}
      {read.at !== null && <span class="muted">{t.gauge.readAt(clock(read.at))}</span>}
    </p>
  )
}

/** What the user lacks for all commands: the role, or control. */
function Permission(): JSX.Element | null {
  const session = useSession()
  const { now, connected } = useLive()
  const control = useSnapshot().control_authority
  if (!hasRole(session, 'operator')) {
    return <p class="muted permission">{t.gauge.rolesNeeded}</p>
  }
  if (control.holder === session.name) return null
  const canRequest = controlActions(control, session, now).includes('request')
  return (
    <p class="muted permission">
      {t.gauge.controlNeeded(controlText(control, session))}{' '}
      {canRequest && (
        <button
          type="button"
          disabled={!connected}
          title={connected ? undefined : t.control.noConnection}
          onClick={() => void changeControl('request').catch(() => {})}
        >
          {t.control.actions.request.label}
        </button>
      )}
    </p>
  )
}

interface ItemProps {
  command: Command
  words: string
  open: (request: Request) => void
}

function Item({ command, words, open }: ItemProps): JSX.Element {
  const session = useSession()
  const control = useSnapshot().control_authority
  const reason = obstacle(session, control, command.role, command.blocked_reason)
  const id = `command-${command.command}`
  return (
    <li data-command={command.command}>
      <button
        type="button"
        disabled={reason !== null}
        title={reason ?? undefined}
        aria-describedby={id}
        onClick={() => open({ command: command.command })}
      >
        {words} …
      </button>
      <span class="command-facts" id={id}>
        {words !== command.command && <code class="muted">{command.command}</code>}{' '}
        {command.risk.class !== 'harmless' && <RiskMark risk={command.risk} />}{' '}
        {command.from_device_file && <DeviceFileMark />}{' '}
        {command.risk.class === 'dangerous' && <RiskText risk={command.risk} />}
        {command.conditions.length > 0 && (
          <span class="muted">
            {' '}
            {t.gauge.conditions(<span lang="en">{readable(command.conditions.join('; '))}</span>)}
          </span>
        )}
        {reason && reason !== t.control.needsControl && <em class="muted"> {reason}</em>}
      </span>
    </li>
  )
}
