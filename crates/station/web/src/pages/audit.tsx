// Who did what to which gauge or alarm, and what came of it: the latest first.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { audit, auditAddress, type Audited, type Filter } from '../acting.ts'
import { useLive } from '../live.ts'
import { useAsked } from '../parts/use.ts'
import { clock, day } from '../pure/format.ts'
import { gaugePath, Link } from '../router.tsx'

const AGAIN_MS = 3_000
const PAGE = 100
const DAY_MS = 86_400_000

const WHATS: Record<Audited['what'], string> = {
  fired: 'fired',
  outcome: 'outcome',
  refused: 'refused',
  disarmed: 'disarmed',
  mastership: 'mastership',
  acknowledged: 'acknowledged',
  'taken-out-of-service': 'out of service',
  'returned-to-service': 'back in service',
}

const TIMES: [string, number | null][] = [
  ['all times', null],
  ['last day', DAY_MS],
  ['last week', 7 * DAY_MS],
  ['last month', 30 * DAY_MS],
]

export function Audit(): JSX.Element {
  const live = useLive()
  const [most, setMost] = useState(PAGE)
  const [gauge, setGauge] = useState('')
  const [who, setWho] = useState('')
  const [back, setBack] = useState<number | null>(null)
  const filter: Filter = { gauge, who, most, from: back === null ? null : live.now - back, to: null }
  const asked = useAsked(`${most} ${gauge} ${who} ${back}`, AGAIN_MS, (signal) => audit(filter, signal))
  const rows = asked.value ?? []
  return (
    <section class="panel events audit" aria-label="Audit">
      <div class="bar">
        <h1>Audit</h1>
        <select aria-label="Gauge" value={gauge} onChange={(event) => setGauge(event.currentTarget.value)}>
          <option value="">all gauges</option>
          {live.moment!.gauges.map(({ name }) => (
            <option value={name} key={name}>
              {name}
            </option>
          ))}
        </select>
        <input
          type="search"
          placeholder="Who"
          aria-label="Who"
          value={who}
          onInput={(event) => setWho(event.currentTarget.value.trim())}
        />
        <select
          aria-label="Time"
          value={String(back)}
          onChange={(event) => setBack(event.currentTarget.value === 'null' ? null : Number(event.currentTarget.value))}
        >
          {TIMES.map(([words, ms]) => (
            <option value={String(ms)} key={words}>
              {words}
            </option>
          ))}
        </select>
        <a class="button" href={auditAddress(filter)} download="audit.csv">
          Save as CSV
        </a>
      </div>
      {asked.error && <p class="alarm">{asked.error}</p>}
      <table>
        <thead>
          <tr>
            <th>Time</th>
            <th>Who</th>
            <th>What</th>
            <th>Gauge</th>
            <th>Target</th>
            <th>Before → after</th>
            <th>Outcome</th>
          </tr>
        </thead>
        <tbody>
          {rows.map((row) => (
            <Row row={row} key={row.id} />
          ))}
        </tbody>
      </table>
      {asked.value && rows.length === 0 && (
        <p class="muted">{gauge || who || back !== null ? 'Nothing matches.' : 'Nobody has done anything yet.'}</p>
      )}
      {rows.length === most && (
        <button type="button" onClick={() => setMost(most + PAGE)}>
          Older ones
        </button>
      )}
    </section>
  )
}

function Row({ row }: { row: Audited }): JSX.Element {
  const { id, at_ms, what, of, who, role, peer, gauge, address, target, before, after, outcome } = row
  return (
    <tr data-what={what}>
      <td class="time">
        <span class="muted">{day(at_ms)}</span> {clock(at_ms)} <span class="muted">#{id}</span>
      </td>
      <td>
        {who} <span class="muted">{[role, peer].filter(Boolean).join(', ')}</span>
      </td>
      <td>
        <span class={`kind ${what}`}>{WHATS[what]}</span>
        {of !== null && <span class="muted"> of #{of}</span>}
      </td>
      <td>
        {gauge && (
          <>
            <Link to={gaugePath(gauge)}>{gauge}</Link> {address !== null && <span class="muted">{address}</span>}
          </>
        )}
      </td>
      <td>{target}</td>
      <td>{before === null ? after : `${before} → ${after ?? 'unknown'}`}</td>
      <td>{outcome}</td>
    </tr>
  )
}
