// The statistics of a segment: what the station hears on the line, station by station, with histograms, events and captures.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { captureAddress, fetchBus, fetchCaptures, makeCapture } from '../api/calls.ts'
import type { BusDistribution, BusReport, BusStationReport, Capture } from '../api/types.ts'
import { errorText, useQuery } from '../components/hooks.ts'
import { QueryState } from '../components/query-state.tsx'
import { age } from '../lib/format.ts'
import { hasRole, useSession } from '../session.ts'
import { t } from '../texts/texts.ts'

/** The report changes once a second. */
const PERIOD_MS = 2000

export function Statistics({ segment }: { segment: string }): JSX.Element {
  const [open, setOpen] = useState(false)
  return (
    <details class="statistics" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>{t.bus.statistics}</summary>
      {open && <Report segment={segment} />}
    </details>
  )
}

function Report({ segment }: { segment: string }): JSX.Element {
  const query = useQuery(segment, PERIOD_MS, (signal) => fetchBus(segment, signal))
  const { value } = query
  if (!value) return <QueryState of={[query]} />
  return (
    <>
      <QueryState of={[query]} />
      <p>
        {t.bus.telegrams(value.telegrams, age(value.observed_ms), value.damaged, value.damaged_last_minute)}{' '}
        {value.ring.length > 0 && t.bus.ring(value.ring.join(' → '))}
      </p>
      <Stations report={value} />
      <Histogram title={t.bus.cycleTime} times={value.cycle} />
      <Histogram title={t.bus.rotation} times={value.rotation} />
      <Parameters report={value} />
      <Events report={value} />
      <Captures segment={segment} />
    </>
  )
}

function Stations({ report }: { report: BusReport }): JSX.Element {
  return (
    <table class="stacked">
      <caption>{t.bus.stations}</caption>
      <thead>
        <tr>
          {t.bus.columns.map((title) => (
            <th scope="col" key={title}>
              {title}
            </th>
          ))}
          <th scope="col">{t.bus.diagnosis}</th>
        </tr>
      </thead>
      <tbody>
        {report.stations.map((station) => (
          <StationRow station={station} key={station.address} />
        ))}
      </tbody>
    </table>
  )
}

function StationRow({ station }: { station: BusStationReport }): JSX.Element {
  const { total, last_minute: minute } = station
  const count = (total: number, minute: number): JSX.Element => (
    <>
      {total} <span class="muted">{minute}</span>
    </>
  )
  const cells = [
    t.bus.lineStates[station.state],
    station.devices.join(', '),
    count(total.requests, minute.requests),
    count(total.lost, minute.lost),
    count(total.repeated, minute.repeated),
    station.longest_sequence,
    count(total.damaged, minute.damaged),
    count(total.refused, minute.refused),
  ]
  const [address, ...titles] = t.bus.columns
  return (
    <tr>
      <th scope="row" data-title={address}>
        {station.address}
      </th>
      {cells.map((cell, index) => (
        <td data-title={titles[index]} key={titles[index]}>
          {cell}
        </td>
      ))}
      <td data-title={t.bus.diagnosis}>{[...station.diagnosis, ...station.unknown].join('; ')}</td>
    </tr>
  )
}

function Histogram({ title, times }: { title: string; times: BusDistribution }): JSX.Element {
  const most = Math.max(1, ...times.buckets.map(({ count }) => count))
  return (
    <table class="histogram">
      <caption>
        {title}: {times.mean_us === null ? t.bus.notKnown : t.bus.average(ms(times.mean_us), ms(times.max_us ?? 0))}
      </caption>
      <tbody>
        {times.buckets.map(({ end_us, count }) => (
          <tr key={end_us}>
            <th scope="row">{t.bus.below(ms(end_us))}</th>
            <td>
              <svg class="bar-of-counts" viewBox={`0 0 ${most} 1`} preserveAspectRatio="none" aria-hidden="true">
                <rect width={count} height="1" />
              </svg>
            </td>
            <td>{count}</td>
          </tr>
        ))}
      </tbody>
    </table>
  )
}

const ms = (us: number): string => `${(us / 1000).toPrecision(3)} ms`

function Parameters({ report }: { report: BusReport }): JSX.Element | null {
  const entries = report.parameters.map(({ address, requester, name, value, done, path }) => (
    <li key={`${address} ${requester} ${name} ${path}`}>
      {t.bus.parameter(address, name)} {value && `= ${value}`}{' '}
      <span class="muted">{t.bus.byMaster(t.bus.done[done], requester)}</span>
    </li>
  ))
  return entries.length > 0 ? <ShortList title={t.bus.parameters} entries={entries} /> : null
}

function Events({ report }: { report: BusReport }): JSX.Element {
  const entries = report.events.map(({ number, age_ms, text }) => (
    <li key={number}>
      <span lang="en">{text}</span> <span class="muted">{t.common.ago(age(age_ms))}</span>
    </li>
  ))
  return <ShortList title={t.bus.events} entries={entries} />
}

/** The entries that a list shows at first. */
const SHOWN = 20

/** A list under a heading, which a button shows whole. */
function ShortList({ title, entries }: { title: string; entries: JSX.Element[] }): JSX.Element {
  const [isWhole, setWhole] = useState(false)
  return (
    <>
      <h3>{title}</h3>
      <ul aria-label={title}>{isWhole ? entries : entries.slice(0, SHOWN)}</ul>
      {!isWhole && entries.length > SHOWN && (
        <button type="button" onClick={() => setWhole(true)}>
          {t.bus.showAll(entries.length)}
        </button>
      )}
    </>
  )
}

function Captures({ segment }: { segment: string }): JSX.Element {
  const session = useSession()
  const [refusal, setRefusal] = useState<string | null>(null)
  const query = useQuery(segment, PERIOD_MS, (signal) => fetchCaptures(segment, signal))
  const make = (): void => {
    makeCapture(segment).then(
      () => setRefusal(null),
      (error: unknown) => setRefusal(errorText(error)),
    )
  }
  return (
    <>
      <h3>{t.bus.captures}</h3>
      {hasRole(session, 'operator') && (
        <button type="button" onClick={make}>
          {t.bus.makeCapture}
        </button>
      )}
      {refusal && <p class="error">{refusal}</p>}
      <QueryState of={[query]} empty={query.value?.length === 0 && t.bus.noCaptures} />
      <ul aria-label={t.bus.captures}>
        {(query.value ?? []).map(({ name, octets }: Capture) => (
          <li key={name}>
            <a href={captureAddress(segment, name)} download={name}>
              {name}
            </a>{' '}
            <span class="muted">{Math.ceil(octets / 1024)} KiB</span>
          </li>
        ))}
      </ul>
    </>
  )
}
