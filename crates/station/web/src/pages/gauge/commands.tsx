// The commands of a gauge, with their conditions and risks.

import './commands.css'
import type { JSX } from 'preact'
import { changeControl, fetchCommands } from '../../api/calls.ts'
import type { Command, Gauge, Request } from '../../api/types.ts'
import { DeviceFileMark, RiskMark } from '../../components/command-dialog.tsx'
import { controlActions, controlText } from '../../components/control.tsx'
import { useQuery } from '../../components/hooks.ts'
import { QueryState } from '../../components/query-state.tsx'
import { readable } from '../../lib/format.ts'
import { useLive, useSnapshot } from '../../live.ts'
import { hasRole, useSession } from '../../session.ts'
import { t } from '../../texts/texts.ts'
import { obstacle } from './permission.ts'

export function Commands({ gauge, open }: { gauge: Gauge; open: (request: Request) => void }): JSX.Element {
  const query = useQuery(gauge.name, null, (signal) => fetchCommands(gauge.name, signal))
  // The manuals have commands that do nothing: `inactive` in every block, `ready-to-store` of a controller.
  const commands = (query.value ?? []).filter(({ command }) => !/[./](inactive|ready-to-store)$/.test(command))
  return (
    <section class="panel commands" aria-label={t.gauge.commands}>
      <div class="bar">
        <h2>{t.gauge.commands}</h2>
      </div>
      <Permission />
      <QueryState of={[query]} empty={commands.length === 0 && t.gauge.noCommands} />
      {commands.length > 0 && (
        <ul>
          {commands.map((command) => (
            <Item command={command} open={open} key={command.command} />
          ))}
        </ul>
      )}
    </section>
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

function Item({ command, open }: { command: Command; open: (request: Request) => void }): JSX.Element {
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
        {command.command} …
      </button>
      <span class="command-facts" id={id}>
        <RiskMark risk={command.risk} /> {command.from_device_file && <DeviceFileMark />}{' '}
        {command.risk.class === 'dangerous' && <span lang="en">{command.risk.description}</span>}
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
