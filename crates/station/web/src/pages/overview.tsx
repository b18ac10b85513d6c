// All gauges as cards, segment by segment.

import './overview.css'
import type { JSX } from 'preact'
import type { Alarm, Gauge, Reading, Segment } from '../api/types.ts'
import { CardAlarms } from '../components/alarm-marks.tsx'
import { BusStatusMark } from '../components/bus-status.tsx'
import { CorrectedPressure, Pressure, RangeLimit, ReadingText } from '../components/pressure.tsx'
import { Age, Faults } from '../components/reading-state.tsx'
import { Sparkline } from '../components/sparkline.tsx'
import { PRINCIPLES } from '../lib/labels.ts'
import { currentQuality, isStale } from '../lib/stale.ts'
import type { Unit } from '../lib/units.ts'
import { type Live, useLive, useSnapshot } from '../live.ts'
import { gaugePath, Link } from '../router.tsx'
import { useUnit } from '../settings.ts'

export function Overview(): JSX.Element {
  const live = useLive()
  const unit = useUnit()
  const { segments, gauges, alarms } = useSnapshot()
  const alarmsOf = ({ name }: Gauge): Alarm[] => alarms.alarms.filter(({ gauge }) => gauge === name)
  return (
    <>
      <h1 class="visually-hidden">Overview</h1>
      {segments.map((segment) => (
        <section class="segment" key={segment.name} aria-label={`Segment ${segment.name}`}>
          <SegmentHeading segment={segment} />
          <div class="cards">
            {gauges
              .filter((gauge) => gauge.segment === segment.name)
              .map((gauge) => (
                <Card gauge={gauge} alarms={alarmsOf(gauge)} live={live} unit={unit} key={gauge.name} />
              ))}
          </div>
        </section>
      ))}
      {segments.length === 0 && <p class="waiting">The station has no segments.</p>}
    </>
  )
}

function SegmentHeading({ segment }: { segment: Segment }): JSX.Element {
  return (
    <h2>
      {segment.name}
      {segment.problem && <span class="problem"> {segment.problem}</span>}
    </h2>
  )
}

function Card(props: { gauge: Gauge; alarms: Alarm[]; live: Live; unit: Unit }): JSX.Element {
  const { gauge, alarms, live, unit } = props
  const stale = isStale(gauge, live.since)
  const several = gauge.readings.length > 1
  return (
    <article class={`card ${stale ? 'stale' : ''} ${several ? 'several' : ''}`} data-gauge={gauge.name}>
      <div class="card-head">
        <h3>
          <Link to={gaugePath(gauge.name)}>{gauge.name}</Link>
        </h3>
        <BusStatusMark status={gauge.state} stale={stale && gauge.state === 'data-exchange'} />
      </div>
      {gauge.readings.map((reading) => (
        <CardReading gauge={gauge} reading={reading} live={live} unit={unit} several={several} key={reading.series} />
      ))}
      {gauge.readings.length === 0 && <p class="big none">no data</p>}
      <Faults gauge={gauge} />
      <CardAlarms alarms={alarms} />
      <p class="card-foot">
        <span>{gauge.device}</span>
        <Age gauge={gauge} live={live} />
      </p>
      {!several && gauge.readings[0] && <Sparkline series={gauge.readings[0].series} stale={stale} />}
    </article>
  )
}

interface CardReadingProps {
  gauge: Gauge
  reading: Reading
  live: Live
  unit: Unit
  /** Whether the gauge has several readings. */
  several: boolean
}

function CardReading({ gauge, reading, live, unit, several }: CardReadingProps): JSX.Element {
  const quality = currentQuality(gauge, reading, live.since)
  const sensor = reading.principle ? PRINCIPLES[reading.principle] : ''
  return (
    <div class="card-reading">
      <p class="big" data-series={reading.series}>
        {quality === 'gap' && reading.pa !== null ? (
          <Pressure pa={reading.pa} unit={unit} />
        ) : (
          <ReadingText pa={reading.pa} quality={quality} unit={unit} />
        )}
      </p>
      <p class="reading-details">
        <span class="sensor">{[several ? reading.instance : '', sensor].filter(Boolean).join(' · ')}</span>
        <RangeLimit pa={reading.pa} quality={quality} unit={unit} />
        {quality === 'valid' && <CorrectedPressure gauge={gauge} reading={reading} unit={unit} />}
      </p>
    </div>
  )
}
