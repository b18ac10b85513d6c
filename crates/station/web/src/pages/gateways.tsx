// The gateways to control systems, with their clients, counts and errors.

import './gateways.css'
import type { JSX } from 'preact'
import { fetchGateways } from '../api/calls.ts'
import type { ArchiveLink, Gateway } from '../api/types.ts'
import { useQuery } from '../components/hooks.ts'
import { type Column, LogTable, Time } from '../components/log.tsx'
import { grouped } from '../lib/format.ts'
import { gatewayState, gatewayTitle } from '../lib/gateways.ts'
import { t } from '../texts/texts.ts'

const REFRESH_MS = 2_000

const count = (title: string, of: (gateway: Gateway) => number): Column<Gateway> => ({
  title,
  class: 'count',
  cell: (gateway) => <span data-title={title}>{grouped(of(gateway))}</span>,
})

const columns = (): Column<Gateway>[] => [
  { title: t.gateways.gateway, cell: ({ name }) => <strong>{gatewayTitle(name)}</strong> },
  {
    title: t.common.state,
    cell: (gateway) => (
      <>
        <span class={gateway.is_running ? '' : 'stopped'}>{gatewayState(gateway)}</span>
        {gateway.archive && <Batches archive={gateway.archive} />}
      </>
    ),
  },
  { title: t.gateways.address, cell: ({ address }) => address },
  count(t.gateways.clients, ({ clients }) => clients),
  count(t.gateways.sent, ({ sent }) => sent),
  count(t.gateways.dropped, ({ dropped_updates }) => dropped_updates),
  count(t.gateways.refused, ({ refused }) => refused),
  {
    title: t.gateways.lastError,
    cell: ({ last_error, last_error_ms }) =>
      last_error && (
        <>
          {last_error_ms !== null && <Time at={last_error_ms} />} {last_error}
        </>
      ),
  },
]

/** What waits for the archive, since when, and when it answered last. */
function Batches({ archive }: { archive: ArchiveLink }): JSX.Element {
  const { waiting, oldest_ms, last_answer_ms, put_aside, put_aside_reason } = archive
  return (
    <div class="muted batches">
      {t.gateways.waiting(grouped(waiting))}
      {oldest_ms !== null && (
        <>
          , {t.gateways.oldest} <Time at={oldest_ms} />
        </>
      )}
      {last_answer_ms !== null && (
        <>
          ; {t.gateways.answered} <Time at={last_answer_ms} />
        </>
      )}
      {put_aside > 0 && (
        <span class="stopped">
          ; {t.gateways.putAside(grouped(put_aside))}: {put_aside_reason}
        </span>
      )}
    </div>
  )
}

export function Gateways(): JSX.Element {
  const query = useQuery('gateways', REFRESH_MS, (signal) => fetchGateways(signal))
  const log = { entries: query.value ?? [], query, showOlder: null }
  return (
    <section class="panel gateways" aria-label={t.pages['/gateways']}>
      <div class="bar">
        <h1>{t.pages['/gateways']}</h1>
      </div>
      <LogTable
        caption={t.gateways.caption}
        columns={columns()}
        log={log}
        shown={log.entries}
        keyOf={({ name }) => name}
        kindOf={({ is_running }) => (is_running ? 'running' : 'stopped')}
        empty={{
          none: t.gateways.none,
          filtered: '',
          isFiltered: false,
        }}
      />
    </section>
  )
}
