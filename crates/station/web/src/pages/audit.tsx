// The audit trail: every command, parameter change, alarm action and change of control, with its user and outcome.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { type AuditFilter, auditAddress, fetchAudit } from '../api/calls.ts'
import type { AuditAction, AuditEntry } from '../api/types.ts'
import { Choice, SearchField, sameText } from '../components/fields.tsx'
import { type Column, LogTable, Time, useLog } from '../components/log.tsx'
import { useSnapshot } from '../live.ts'
import { gaugePath, Link } from '../router.tsx'

const DAY_MS = 86_400_000

const ACTIONS: Record<AuditAction, string> = {
  execute: 'sent',
  outcome: 'outcome',
  refused: 'refused',
  disarmed: 'disarmed',
  'control-authority': 'control',
  acknowledged: 'acknowledged',
  shelved: 'shelved',
  unshelved: 'unshelved',
  'taken-out-of-service': 'out of service',
  'returned-to-service': 'back in service',
  'alarm-settings': 'settings',
  'plant-state-declared': 'plant state declared',
  'plant-state-extended': 'plant state extended',
  'plant-state-ended': 'plant state ended',
}

const PERIODS: [string, string][] = [
  ['', 'all times'],
  [`${DAY_MS}`, 'last day'],
  [`${7 * DAY_MS}`, 'last week'],
  [`${30 * DAY_MS}`, 'last month'],
]

const COLUMNS: Column<AuditEntry>[] = [
  {
    title: 'Time',
    class: 'time',
    cell: ({ id, at_ms }) => (
      <>
        <Time at={at_ms} /> <span class="muted">#{id}</span>
      </>
    ),
  },
  {
    title: 'User',
    cell: ({ user, role, peer }) => (
      <>
        {user} <span class="muted">{[role, peer].filter(Boolean).join(', ')}</span>
      </>
    ),
  },
  {
    title: 'Action',
    cell: ({ action, refers_to }) => (
      <>
        <span class={`kind ${action}`}>{ACTIONS[action]}</span>
        {refers_to !== null && <span class="muted"> of #{refers_to}</span>}
      </>
    ),
  },
  {
    title: 'Gauge',
    cell: ({ gauge, address }) =>
      gauge && (
        <>
          <Link to={gaugePath(gauge)}>{gauge}</Link> {address !== null && <span class="muted">address {address}</span>}
        </>
      ),
  },
  { title: 'Target', cell: ({ target }) => target },
  {
    title: 'Before → after',
    cell: ({ before, after }) => (before === null ? after : `${before} → ${after ?? 'unknown'}`),
  },
  { title: 'Outcome', cell: ({ outcome }) => outcome },
]

export function Audit(): JSX.Element {
  const { gauges, station } = useSnapshot()
  const [gauge, setGauge] = useState('')
  const [user, setUser] = useState('')
  const [period, setPeriod] = useState('')
  const filter: AuditFilter = { gauge, user, from: period ? station.now_ms - Number(period) : null }
  const log = useLog(`${gauge} ${user} ${period}`, (limit, signal) => fetchAudit(filter, limit, signal))
  const names = sameText(gauges.map(({ name }) => name))
  return (
    <section class="panel audit" aria-label="Audit">
      <div class="bar">
        <h1>Audit</h1>
        <Choice label="Gauge" value={gauge} options={[['', 'all gauges'], ...names]} onChange={setGauge} />
        <SearchField label="User" placeholder="User" value={user} onInput={(text) => setUser(text.trim())} />
        <Choice label="Time" value={period} options={PERIODS} onChange={setPeriod} />
        <a class="button" href={auditAddress(filter)} download="audit.csv">
          Save as CSV
        </a>
      </div>
      <LogTable
        caption="Audit trail, the latest entry first"
        columns={COLUMNS}
        log={log}
        shown={log.entries}
        keyOf={({ id }) => id}
        kindOf={({ action }) => action}
        empty={{ none: 'No entries yet.', filtered: 'No entry matches.', isFiltered: Boolean(gauge || user || period) }}
      />
    </section>
  )
}
