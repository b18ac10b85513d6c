// The bus map: all addresses of each segment, with the bus status of the station at each address.

import './bus.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import type { BusStation, BusStatus, Segment } from '../api/types.ts'
import { BusStatusMark, StatusDot } from '../components/bus-status.tsx'
import { number } from '../lib/format.ts'
import { baud, segmentSentence } from '../lib/labels.ts'
import { useLive, useSnapshot } from '../live.ts'
import { gaugePath, Link } from '../router.tsx'
import { t } from '../texts/texts.ts'
import { Statistics } from './bus-statistics.tsx'

/** All station addresses; 126 is the address of a slave that has none yet. */
const ADDRESSES = Array.from({ length: 127 }, (_, address) => address)

export function BusMap(): JSX.Element {
  const { segments } = useSnapshot()
  return (
    <>
      <h1 class="visually-hidden">{t.pages['/bus']}</h1>
      <Legend segments={segments} />
      {segments.map((segment) => (
        <SegmentMap segment={segment} key={segment.name} />
      ))}
    </>
  )
}

function Legend({ segments }: { segments: Segment[] }): JSX.Element {
  const stations = segments.flatMap(({ stations }) => stations)
  const { connected } = useLive()
  const count = (status: BusStatus): number => stations.filter(({ state }) => state === status).length
  return (
    <ul class="legend" aria-label={t.bus.status}>
      {(Object.keys(t.busStatus) as BusStatus[]).map((status) => (
        <li key={status}>
          <BusStatusMark status={status} stale={!connected} /> <span>{count(status)}</span>
        </li>
      ))}
    </ul>
  )
}

function SegmentMap({ segment }: { segment: Segment }): JSX.Element {
  const { connected } = useLive()
  const [chosen, setChosen] = useState<number | null>(null)
  const stations = new Map(segment.stations.map((station) => [station.address, station]))
  const station = chosen === null ? null : (stations.get(chosen) ?? null)
  return (
    <section
      class={`panel segment-map ${connected ? '' : 'not-current'}`}
      aria-label={t.overview.segment(segment.name)}
      data-segment={segment.name}
    >
      <h2>{segment.name}</h2>
      <p class={`sentence ${segment.problem && connected ? 'bad' : ''}`}>
        {connected ? segmentSentence(segment) : t.bus.notCurrent}
      </p>
      <Facts segment={segment} />
      <div class="addresses">
        {ADDRESSES.map((address) => (
          <Cell
            address={address}
            station={stations.get(address)}
            chosen={address === chosen}
            stale={!connected}
            choose={setChosen}
            key={address}
          />
        ))}
      </div>
      <Details station={station} stale={!connected} />
      <Statistics segment={segment.name} />
    </section>
  )
}

function Facts({ segment }: { segment: Segment }): JSX.Element {
  const facts: [string, string][] = [
    [t.bus.port, segment.port],
    [t.bus.baud, baud(segment.baud)],
    [t.bus.state, t.segmentStates[segment.state]],
    [t.bus.cycle, segment.cycle_ms === null ? '–' : `${number(segment.cycle_ms)} ms`],
    [t.bus.damaged, `${segment.damaged_telegrams}`],
    segment.listen_only ? [t.bus.sends, t.bus.listensOnly] : [t.bus.master, `${segment.master}`],
  ]
  return (
    <dl class="facts">
      {facts.map(([name, value]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>{value}</dd>
        </div>
      ))}
    </dl>
  )
}

interface CellProps {
  address: number
  station: BusStation | undefined
  chosen: boolean
  stale: boolean
  choose: (address: number) => void
}

function Cell({ address, station, chosen, stale, choose }: CellProps): JSX.Element {
  if (!station) return <span class="cell empty">{address}</span>
  const text = `${address}: ${station.name ?? t.busStatus[station.state].label}, ${station.description}`
  return (
    <button
      type="button"
      class={`cell ${station.state}`}
      aria-pressed={chosen}
      aria-label={text}
      title={text}
      onClick={() => choose(address)}
    >
      <StatusDot status={stale ? 'stale' : station.state} />
      {address}
    </button>
  )
}

function Details({ station, stale }: { station: BusStation | null; stale: boolean }): JSX.Element {
  if (!station) return <p class="station-details muted">{t.bus.press}</p>
  return (
    <p class="station-details" role="status">
      <strong>{station.address}</strong> <BusStatusMark status={station.state} stale={stale} />{' '}
      {station.name && <Link to={gaugePath(station.name)}>{station.name}</Link>}{' '}
      {[station.device, station.ident, station.description].filter(Boolean).join(' · ')}
      <span class="muted"> {t.busStatus[station.state].sentence}</span>
    </p>
  )
}
