// Who is on the bus: all addresses of a segment at once, in plain colours, with words.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import type { OnBus, Segment, Standing } from '../api.ts'
import { useLive } from '../live.ts'
import { StandingMark } from '../parts/standing.tsx'
import { number } from '../pure/format.ts'
import { baud, segmentSentence, STANDINGS, STATES } from '../pure/words.ts'
import { gaugePath, Link } from '../router.tsx'

/** Every address that a station can have; 126 is that of a slave that was given none yet. */
const ADDRESSES = Array.from({ length: 127 }, (_, address) => address)

export function Bus(): JSX.Element {
  const { segments } = useLive().moment!
  return (
    <>
      <h1 class="unseen">Bus map</h1>
      <Legend segments={segments} />
      {segments.map((segment) => (
        <Map segment={segment} key={segment.name} />
      ))}
    </>
  )
}

function Legend({ segments }: { segments: Segment[] }): JSX.Element {
  const count = (standing: Standing): number =>
    segments.flatMap(({ stations }) => stations).filter((one) => one.standing === standing).length
  return (
    <ul class="legend" aria-label="Colours">
      {(Object.keys(STANDINGS) as Standing[]).map((standing) => (
        <li key={standing}>
          <StandingMark standing={standing} /> <span class="count">{count(standing)}</span>
        </li>
      ))}
    </ul>
  )
}

function Map({ segment }: { segment: Segment }): JSX.Element {
  const [chosen, setChosen] = useState<number | null>(null)
  const at = new globalThis.Map(segment.stations.map((station) => [station.address, station]))
  const station = chosen === null ? null : (at.get(chosen) ?? null)
  return (
    <section class="panel map" aria-label={`Segment ${segment.name}`} data-segment={segment.name}>
      <h2>{segment.name}</h2>
      <p class={`sentence ${segment.trouble ? 'bad' : ''}`}>{segmentSentence(segment)}</p>
      <Facts segment={segment} />
      <div class="addresses">
        {ADDRESSES.map((address) => (
          <Cell
            address={address}
            station={at.get(address)}
            chosen={address === chosen}
            choose={setChosen}
            key={address}
          />
        ))}
      </div>
      <Detail station={station} />
    </section>
  )
}

function Facts({ segment }: { segment: Segment }): JSX.Element {
  const cycle = segment.cycle_ms === null ? '–' : `${number(segment.cycle_ms)} ms`
  const facts: [string, string][] = [
    ['port', segment.port],
    ['rate', baud(segment.baud)],
    ['state', STATES[segment.state]],
    ['cycle', cycle],
    ['damaged telegrams', `${segment.damaged}`],
    ['our master', `${segment.master}`],
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
  station: OnBus | undefined
  chosen: boolean
  choose: (address: number) => void
}

function Cell({ address, station, chosen, choose }: CellProps): JSX.Element {
  if (!station) return <span class="cell empty">{address}</span>
  const words = `${address}: ${station.name ?? STANDINGS[station.standing].word}, ${station.words}`
  return (
    <button
      type="button"
      class={`cell ${station.standing}`}
      aria-pressed={chosen}
      aria-label={words}
      title={words}
      onClick={() => choose(address)}
    >
      {address}
    </button>
  )
}

function Detail({ station }: { station: OnBus | null }): JSX.Element {
  if (!station) return <p class="detail muted">Press an address to see who it is.</p>
  return (
    <p class="detail" role="status">
      <strong>{station.address}</strong> <StandingMark standing={station.standing} />{' '}
      {station.name && <Link to={gaugePath(station.name)}>{station.name}</Link>}{' '}
      {[station.device, station.ident, station.words].filter(Boolean).join(' · ')}
      <span class="muted"> {STANDINGS[station.standing].sentence}</span>
    </p>
  )
}
