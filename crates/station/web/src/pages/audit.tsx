// The audit trail: every command, parameter change, alarm action and change of control, with its user and outcome.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { type AuditFilter, auditAddress, fetchAudit } from '../api/calls.ts'
import type { AuditEntry } from '../api/types.ts'
import { BackupDialog } from '../components/backup-dialog.tsx'
import { Choice, SearchField, sameText } from '../components/fields.tsx'
import { type Column, LogTable, Time, useLog } from '../components/log.tsx'
import { withLocalTimes } from '../lib/format.ts'
import { changeText } from '../lib/labels.ts'
import { useSnapshot } from '../live.ts'
import { gaugePath, Link } from '../router.tsx'
import { hasRole, useSession } from '../session.ts'
import { t } from '../texts/texts.ts'

const DAY_MS = 86_400_000

const periods = (): [string, string][] => [
  ['', t.audit.allTimes],
  [`${DAY_MS}`, t.audit.lastDay],
  [`${7 * DAY_MS}`, t.audit.lastWeek],
  [`${30 * DAY_MS}`, t.audit.lastMonth],
]

const columns = (): Column<AuditEntry>[] => [
  {
    title: t.common.time,
    class: 'time',
    cell: ({ id, at_ms }) => (
      <>
        <Time at={at_ms} /> <span class="muted">#{id}</span>
      </>
    ),
  },
  {
    title: t.common.user,
    cell: ({ action, user, role, peer }) => (
      <>
        {user} {/* The file is no user, and has no role. */}
        {action !== 'file-changed' && (
          <span class="muted">{[t.roles[role] ?? role, peer].filter(Boolean).join(', ')}</span>
        )}
      </>
    ),
  },
  {
    title: t.audit.action,
    cell: ({ action, refers_to }) => (
      <>
        <span class={`kind ${action}`}>{t.audit.actions[action] ?? action}</span>
        {refers_to !== null && <span class="muted">{t.audit.of(refers_to)}</span>}
      </>
    ),
  },
  {
    title: t.common.gauge,
    cell: ({ gauge, address }) =>
      gauge && (
        <>
          <Link to={gaugePath(gauge)}>{gauge}</Link>{' '}
          {address !== null && <span class="muted">{t.common.address(address)}</span>}
        </>
      ),
  },
  { title: t.audit.target, cell: ({ target }) => target },
  {
    title: t.audit.beforeAfter,
    cell: changeText,
  },
  { title: t.audit.outcome, cell: ({ outcome }) => outcome && <span lang="en">{withLocalTimes(outcome)}</span> },
]

export function Audit(): JSX.Element {
  const { gauges, station } = useSnapshot()
  const [gauge, setGauge] = useState('')
  const [user, setUser] = useState('')
  const [period, setPeriod] = useState('')
  const [copies, setCopies] = useState(0)
  const [isCopying, setCopying] = useState(false)
  const mayCopy = hasRole(useSession(), 'engineer')
  const filter: AuditFilter = { gauge, user, from: period ? station.now_ms - Number(period) : null }
  const log = useLog(`${gauge} ${user} ${period} ${copies}`, (limit, signal) => fetchAudit(filter, limit, signal))
  const names = sameText(gauges.map(({ name }) => name))
  return (
    <section class="panel audit" aria-label={t.pages['/audit']}>
      <div class="bar">
        <h1>{t.pages['/audit']}</h1>
        <Choice
          label={t.common.gauge}
          value={gauge}
          options={[['', t.audit.allGauges], ...names]}
          onChange={setGauge}
        />
        <SearchField
          label={t.common.user}
          placeholder={t.common.user}
          value={user}
          onInput={(text) => setUser(text.trim())}
        />
        <Choice label={t.common.time} value={period} options={periods()} onChange={setPeriod} />
        <a class="button" href={auditAddress(filter)} download="audit.csv">
          {t.common.saveCsv}
        </a>
        {mayCopy && (
          <button type="button" onClick={() => setCopying(true)}>
            {t.backup.open}
          </button>
        )}
      </div>
      <LogTable
        caption={t.audit.caption}
        columns={columns()}
        log={log}
        shown={log.entries}
        keyOf={({ id }) => id}
        kindOf={({ action }) => action}
        empty={{
          none: t.common.noEntries,
          filtered: t.common.noEntryMatches,
          isFiltered: Boolean(gauge || user || period),
        }}
      />
      {isCopying && <BackupDialog made={() => setCopies(copies + 1)} close={() => setCopying(false)} />}
    </section>
  )
}
