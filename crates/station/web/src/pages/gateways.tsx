// The gateways to control systems, with their clients, counts and errors.

import './gateways.css'
import type { JSX } from 'preact'
import { fetchGateways } from '../api/calls.ts'
import type { Gateway } from '../api/types.ts'
import { useQuery } from '../components/hooks.ts'
import { type Column, LogTable, Time } from '../components/log.tsx'
import { gatewayState, gatewayTitle } from '../lib/gateways.ts'

const REFRESH_MS = 2_000

const count = (title: string, of: (gateway: Gateway) => number): Column<Gateway> => ({
  title,
  class: 'count',
  cell: (gateway) => <span data-title={title}>{of(gateway).toLocaleString('en-GB')}</span>,
})

const COLUMNS: Column<Gateway>[] = [
  { title: 'Gateway', cell: ({ name }) => <strong>{gatewayTitle(name)}</strong> },
  {
    title: 'State',
    cell: (gateway) => <span class={gateway.is_running ? '' : 'stopped'}>{gatewayState(gateway)}</span>,
  },
  { title: 'Address', cell: ({ address }) => address },
  count('Clients', ({ clients }) => clients),
  count('Sent', ({ sent }) => sent),
  count('Dropped', ({ dropped_updates }) => dropped_updates),
  count('Refused', ({ refused }) => refused),
  {
    title: 'Last error',
    cell: ({ last_error, last_error_ms }) =>
      last_error && (
        <>
          {last_error_ms !== null && <Time at={last_error_ms} />} {last_error}
        </>
      ),
  },
]

export function Gateways(): JSX.Element {
  const { value, error } = useQuery('gateways', REFRESH_MS, (signal) => fetchGateways(signal))
  const log = { entries: value ?? [], error, isLoaded: value !== null, showOlder: null }
  return (
    <section class="panel gateways" aria-label="Gateways">
      <div class="bar">
        <h1>Gateways</h1>
      </div>
      <LogTable
        caption="Gateways to control systems, since the start of the station"
        columns={COLUMNS}
        log={log}
        shown={log.entries}
        keyOf={({ name }) => name}
        kindOf={({ is_running }) => (is_running ? 'running' : 'stopped')}
        empty={{
          none: 'The file of the station has no gateway. docs/gateways.md describes the tables.',
          filtered: '',
          isFiltered: false,
        }}
      />
    </section>
  )
}
