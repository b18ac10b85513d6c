// All gauges as cards, segment by segment: what a person sees from the other end of the hall.

import type { JSX } from 'preact'
import type { Alarm, Gauge, Reading, Segment } from '../api.ts'
import { useLive, type Live } from '../live.ts'
import { CardAlarms } from '../parts/alarm.tsx'
import { Limit, Pressure, Shown } from '../parts/pressure.tsx'
import { Spark } from '../parts/spark.tsx'
import { StandingMark } from '../parts/standing.tsx'
import { age, clock, day } from '../pure/format.ts'
import { ageOf, isStale, worth } from '../pure/stale.ts'
import type { Unit } from '../pure/units.ts'
import { gas, PRINCIPLES } from '../pure/words.ts'
import { gaugePath, Link } from '../router.tsx'
import { useUnit } from '../settings.ts'

export function Overview(): JSX.Element {
  const live = useLive()
  const unit = useUnit()
  const { segments, gauges, alarms } = live.moment!
  return (
    <>
      <h1 class="unseen">Overview</h1>
      {segments.map((segment) => (
        <section class="segment" key={segment.name} aria-label={`Segment ${segment.name}`}>
          <SegmentHead segment={segment} />
          <div class="cards">
            {gauges
              .filter((gauge) => gauge.segment === segment.name)
              .map((gauge) => (
                <Card
                  gauge={gauge}
                  alarms={alarms.list.filter((alarm) => alarm.gauge === gauge.name)}
                  live={live}
                  unit={unit}
                  key={gauge.name}
                />
              ))}
          </div>
        </section>
      ))}
      {segments.length === 0 && <p class="waiting">The station has no segments.</p>}
    </>
  )
}

function SegmentHead({ segment }: { segment: Segment }): JSX.Element {
  return (
    <h2>
      {segment.name}
      {segment.trouble && <span class="trouble"> {segment.trouble}</span>}
    </h2>
  )
}

function Card({ gauge, alarms, live, unit }: { gauge: Gauge; alarms: Alarm[]; live: Live; unit: Unit }): JSX.Element {
  const stale = isStale(gauge, live.since)
  const several = gauge.readings.length > 1
  return (
    <article class={`card ${stale ? 'stale' : ''} ${several ? 'several' : ''}`} data-gauge={gauge.name}>
      <div class="card-head">
        <h3>
          <Link to={gaugePath(gauge.name)}>{gauge.name}</Link>
        </h3>
        <StandingMark standing={gauge.standing} old={stale && gauge.standing === 'exchanging'} />
      </div>
      {gauge.readings.map((reading) => (
        <Measured gauge={gauge} reading={reading} live={live} unit={unit} several={several} key={reading.series} />
      ))}
      {gauge.readings.length === 0 && <p class="big none">no data</p>}
      <Complaints gauge={gauge} />
      <CardAlarms alarms={alarms} />
      <p class="card-foot">
        <span>{gauge.device}</span>
        <Age gauge={gauge} live={live} />
      </p>
      {!several && gauge.readings[0] && <Spark series={gauge.readings[0].series} dim={stale} />}
    </article>
  )
}

interface MeasuredProps {
  gauge: Gauge
  reading: Reading
  live: Live
  unit: Unit
  several: boolean
}

function Measured({ gauge, reading, live, unit, several }: MeasuredProps): JSX.Element {
  const quality = worth(gauge, reading, live.since)
  const old = quality === 'gap' && reading.pa !== null
  const sensor = reading.principle ? PRINCIPLES[reading.principle] : ''
  return (
    <div class="measured">
      <p class="big" data-series={reading.series}>
        {old ? <Pressure pa={reading.pa!} unit={unit} /> : <Shown pa={reading.pa} quality={quality} unit={unit} />}
      </p>
      <p class="beside">
        <span class="sensor">{[several ? reading.instance : '', sensor].filter(Boolean).join(' · ')}</span>
        <Limit pa={reading.pa} quality={quality} unit={unit} />
        {quality === 'valid' && <Corrected gauge={gauge} reading={reading} unit={unit} />}
      </p>
    </div>
  )
}

/** For which gas the reading is corrected, beside what is indicated. */
export function Corrected({
  gauge,
  reading,
  unit,
}: {
  gauge: Gauge
  reading: Reading
  unit: Unit
}): JSX.Element | null {
  if (gauge.gas.toLowerCase() === 'n2') return null
  if (reading.corrected_pa === null) return <span class="corrected">no factor for {gas(gauge.gas)} here</span>
  return (
    <span class="corrected">
      {gas(gauge.gas)}: <Pressure pa={reading.corrected_pa} unit={unit} />
    </span>
  )
}

export function Complaints({ gauge }: { gauge: Gauge }): JSX.Element | null {
  const sentences = gauge.trouble ? [gauge.trouble, ...gauge.exceptions] : gauge.exceptions
  if (sentences.length === 0) return null
  return (
    <ul class="complaints">
      {sentences.map((sentence) => (
        <li key={sentence}>{sentence}</li>
      ))}
    </ul>
  )
}

/** How old the reading is; since when there is none. */
export function Age({ gauge, live }: { gauge: Gauge; live: Live }): JSX.Element {
  const ms = ageOf(gauge, live.since)
  if (ms === null) return <span class="age">never heard</span>
  if (!isStale(gauge, live.since)) return <span class="age">{ms < 1000 ? 'now' : `${age(ms)} ago`}</span>
  const since = live.now - ms
  return (
    <span class="age old">
      no data since {day(since) === day(live.now) ? '' : `${day(since)} `}
      {clock(since)} ({age(ms)})
    </span>
  )
}
