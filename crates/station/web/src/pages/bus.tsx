// The bus map: the stations of each segment with their bus status, the segments with a problem first.

import './bus.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import type { BusStation, BusStatus, Segment } from '../api/types.ts'
import { BusStatusMark, StatusDot } from '../components/bus-status.tsx'
import { number } from '../lib/format.ts'
import { baud, segmentSentence } from '../lib/labels.ts'
import { ADDRESSES, countOf, freeAddresses, problemsFirst } from '../lib/segments.ts'
import { useLive, useSnapshot } from '../live.ts'
import { gaugePath, Link } from '../router.tsx'
import { t } from '../texts/texts.ts'
import { Statistics } from './bus-statistics.tsx'

export function BusMap(): JSX.Element {
  const { segments } = useSnapshot()
  return (
    <>
      <h1 class="visually-hidden">{t.pages['/bus']}</h1>
      <Legend segments={segments} />
      {problemsFirst(segments).map((segment) => (
        <SegmentMap segment={segment} isAlone={segments.length === 1} key={segment.name} />
      ))}
    </>
  )
}

/** All statuses with the number of their stations, also those that no station has. */
function Legend({ segments }: { segments: Segment[] }): JSX.Element {
  const stations = segments.flatMap(({ stations }) => stations)
  return (
    <div class="bus-head">
      <ul class="legend" aria-label={t.bus.status}>
        {(Object.keys(t.busStatus) as BusStatus[]).map((status) => (
          <Count stations={stations} status={status} key={status} />
        ))}
      </ul>
      <p class="muted">{t.bus.press}</p>
    </div>
  )
}

function Count({ stations, status }: { stations: BusStation[]; status: BusStatus }): JSX.Element {
  const { connected } = useLive()
  return (
    <li>
      <BusStatusMark status={status} stale={!connected} /> <span>{countOf(stations, status)}</span>
    </li>
  )
}

/** A segment: its stations, or on request all addresses. A plant with one segment shows all addresses at first. */
function SegmentMap({ segment, isAlone }: { segment: Segment; isAlone: boolean }): JSX.Element {
  const { connected } = useLive()
  const [isOpen, setOpen] = useState(isAlone)
  const [chosen, setChosen] = useState<number | null>(null)
  const cells = <Addresses segment={segment} isWhole={isOpen} chosen={chosen} choose={setChosen} />
  const details = <Details station={segment.stations.find(({ address }) => address === chosen)} />
  return (
    <section
      class={`panel segment-map ${connected ? '' : 'not-current'}`}
      aria-label={t.overview.segment(segment.name)}
      data-segment={segment.name}
    >
      <div>
        <h2>{segment.name}</h2>
        <Counts segment={segment} />
      </div>
      <div>
        <p class={`sentence ${segment.problem && connected ? 'bad' : ''}`}>
          {connected ? segmentSentence(segment) : t.bus.notCurrent}
        </p>
        <details class="whole" open={isOpen} onToggle={(event) => setOpen(event.currentTarget.open)}>
          <summary>{t.bus.whole(ADDRESSES.length)}</summary>
          {isOpen && (
            <>
              <Facts segment={segment} />
              {cells}
              {details}
              <Statistics segment={segment.name} />
            </>
          )}
        </details>
        {!isOpen && (
          <>
            {cells}
            {details}
          </>
        )}
      </div>
    </section>
  )
}

/** The statuses that stations of the segment have, and the free addresses. */
function Counts({ segment }: { segment: Segment }): JSX.Element {
  const { stations } = segment
  const statuses = (Object.keys(t.busStatus) as BusStatus[]).filter((status) => countOf(stations, status) > 0)
  return (
    <ul class="counts" aria-label={t.bus.status}>
      {statuses.map((status) => (
        <Count stations={stations} status={status} key={status} />
      ))}
      <li class="muted">{t.bus.free(freeAddresses(segment))}</li>
    </ul>
  )
}

interface AddressesProps {
  segment: Segment
  /** Whether the free addresses are shown too. */
  isWhole: boolean
  chosen: number | null
  choose: (address: number) => void
}

function Addresses({ segment, isWhole, chosen, choose }: AddressesProps): JSX.Element {
  const { connected } = useLive()
  const stations = new Map(segment.stations.map((station) => [station.address, station]))
  const shown = isWhole ? ADDRESSES : ADDRESSES.filter((address) => stations.has(address))
  return (
    <div class={isWhole ? 'addresses' : 'addresses compact'}>
      {shown.map((address) => (
        <Cell
          address={address}
          station={stations.get(address)}
          chosen={address === chosen}
          stale={!connected}
          choose={choose}
          key={address}
        />
      ))}
    </div>
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

/** The station at the chosen address; empty before one is chosen. */
function Details({ station }: { station: BusStation | undefined }): JSX.Element {
  const { connected } = useLive()
  return (
    <p class="station-details" role="status">
      {station && (
        <>
          <strong>{station.address}</strong> <BusStatusMark status={station.state} stale={!connected} />{' '}
          {station.name && <Link to={gaugePath(station.name)}>{station.name}</Link>}{' '}
          {[station.device, station.ident, station.description].filter(Boolean).join(' · ')}
          <span class="muted"> {t.busStatus[station.state].sentence}</span>
        </>
      )}
    </p>
  )
}
