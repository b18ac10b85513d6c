// The statistics of a segment: what the station hears on the line, station by station, with histograms, events and captures.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { captureAddress, fetchBus, fetchCaptures, makeCapture } from '../api/calls.ts'
import type { BusDistribution, BusReport, BusStationReport, Capture, LineState } from '../api/types.ts'
import { errorText, useQuery } from '../components/hooks.ts'
import { age } from '../lib/format.ts'
import { hasRole, useSession } from '../session.ts'

/** The report changes once a second. */
const PERIOD_MS = 2000

const LINE_STATES: Record<LineState, string> = {
  master: 'master',
  exchanging: 'exchanging',
  missing: 'missing',
  'not-configured': 'not configured',
  'no-master': 'present without a master',
  'not-addressed': 'not addressed',
}

export function Statistics({ segment }: { segment: string }): JSX.Element {
  const [open, setOpen] = useState(false)
  return (
    <details class="statistics" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>Statistics, events and captures</summary>
      {open && <Report segment={segment} />}
    </details>
  )
}

function Report({ segment }: { segment: string }): JSX.Element {
  const { value, error } = useQuery(segment, PERIOD_MS, (signal) => fetchBus(segment, signal))
  if (!value) return <p class="muted">{error ?? 'Loading.'}</p>
  return (
    <>
      {error && <p class="error">{error}</p>}
      <p>
        {value.telegrams} telegrams in {age(value.observed_ms)}, {value.damaged} damaged, {value.damaged_last_minute} of
        them in the last minute. {value.ring.length > 0 && <>Token ring: {value.ring.join(' → ')}.</>}
      </p>
      <Stations report={value} />
      <Histogram title="Cycle time" times={value.cycle} />
      <Histogram title="Token rotation" times={value.rotation} />
      <Parameters report={value} />
      <Events report={value} />
      <Captures segment={segment} />
    </>
  )
}

function Stations({ report }: { report: BusReport }): JSX.Element {
  return (
    <div class="scroll">
      <table>
        <caption>Stations, with their counts in total and of the last minute</caption>
        <thead>
          <tr>
            {['Address', 'State', 'Device', 'Requests', 'Lost', 'Repeated', 'Longest', 'Damaged', 'Refused'].map(
              (title) => (
                <th scope="col" key={title}>
                  {title}
                </th>
              ),
            )}
            <th scope="col">Diagnosis, and what is not known</th>
          </tr>
        </thead>
        <tbody>
          {report.stations.map((station) => (
            <StationRow station={station} key={station.address} />
          ))}
        </tbody>
      </table>
    </div>
  )
}

function StationRow({ station }: { station: BusStationReport }): JSX.Element {
  const { total, last_minute: minute } = station
  const pairs: [number, number][] = [
    [total.requests, minute.requests],
    [total.lost, minute.lost],
    [total.repeated, minute.repeated],
  ]
  const others: [number, number][] = [
    [total.damaged, minute.damaged],
    [total.refused, minute.refused],
  ]
  return (
    <tr>
      <th scope="row">{station.address}</th>
      <td>{LINE_STATES[station.state]}</td>
      <td>{station.devices.join(', ')}</td>
      {pairs.map(Count)}
      <td>{station.longest_sequence}</td>
      {others.map(Count)}
      <td>{[...station.diagnosis, ...station.unknown].join('; ')}</td>
    </tr>
  )
}

function Count([total, minute]: [number, number], index: number): JSX.Element {
  return (
    <td key={index}>
      {total} <span class="muted">{minute}</span>
    </td>
  )
}

function Histogram({ title, times }: { title: string; times: BusDistribution }): JSX.Element {
  const most = Math.max(1, ...times.buckets.map(({ count }) => count))
  return (
    <table class="histogram">
      <caption>
        {title}:{' '}
        {times.mean_us === null ? 'not known yet' : `${ms(times.mean_us)} on average, longest ${ms(times.max_us ?? 0)}`}
      </caption>
      <tbody>
        {times.buckets.map(({ end_us, count }) => (
          <tr key={end_us}>
            <th scope="row">below {ms(end_us)}</th>
            <td>
              <meter min={0} max={most} value={count} aria-label={`${count} times`} />
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
  if (report.parameters.length === 0) return null
  return (
    <ul aria-label="Parameters that masters read and wrote">
      {report.parameters.map(({ address, requester, name, value, done, path }) => (
        <li key={`${address} ${requester} ${name} ${path}`}>
          station {address}: {name} {value && `= ${value}`}{' '}
          <span class="muted">
            {done} by master {requester}
          </span>
        </li>
      ))}
    </ul>
  )
}

function Events({ report }: { report: BusReport }): JSX.Element {
  return (
    <ul aria-label="Events on the bus">
      {report.events.map(({ number, age_ms, text }) => (
        <li key={number}>
          {text} <span class="muted">{age(age_ms)} ago</span>
        </li>
      ))}
    </ul>
  )
}

function Captures({ segment }: { segment: string }): JSX.Element {
  const session = useSession()
  const [refusal, setRefusal] = useState<string | null>(null)
  const { value, error } = useQuery(segment, PERIOD_MS, (signal) => fetchCaptures(segment, signal))
  const make = (): void => {
    makeCapture(segment).then(
      () => setRefusal(null),
      (error: unknown) => setRefusal(errorText(error)),
    )
  }
  return (
    <>
      <h3>Captures</h3>
      {hasRole(session, 'operator') && (
        <button type="button" onClick={make}>
          Make capture
        </button>
      )}
      {(refusal ?? error) && <p class="error">{refusal ?? error}</p>}
      <ul aria-label="Captures">
        {(value ?? []).map(({ name, octets }: Capture) => (
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
