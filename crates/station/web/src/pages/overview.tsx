// All gauges, segment by segment: below the active alarms as cards in a small plant, as rows with the problems first in a large one.

import './overview.css'
import type { ComponentChildren, JSX } from 'preact'
import { useState } from 'preact/hooks'
import type { Alarm, Gauge, GaugeLabels, Reading, Segment } from '../api/types.ts'
import { CardAlarms } from '../components/alarm-marks.tsx'
import { GaugeStatus } from '../components/bus-status.tsx'
import { FailingNotifications } from '../components/failing-notifications.tsx'
import {
  FilterFields,
  labelsOf,
  Overdue,
  passesNow,
  UnknownState,
  useDirectory,
  useFilter,
} from '../components/gauge-filter.tsx'
import { AlarmLines, OtherAlarms } from '../components/other-alarms.tsx'
import { hasPicture, Picture, Story, usePlant } from '../components/plant-picture.tsx'
import { Points } from '../components/points.tsx'
import { boundOf, ReadingDetails, ReadingText } from '../components/pressure.tsx'
import { QueryState } from '../components/query-state.tsx'
import { Age, Faults } from '../components/reading-state.tsx'
import { Sparkline } from '../components/sparkline.tsx'
import { Views } from '../components/views.tsx'
import { isActive, PRIORITIES } from '../lib/alarms.ts'
import { isFiltered as hasFilter, needsLabels } from '../lib/filter.ts'
import { pressureRange } from '../lib/pressure-range.ts'
import { currentQuality, isStale } from '../lib/stale.ts'
import type { Unit } from '../lib/units.ts'
import { type Live, useLive, useSnapshot } from '../live.ts'
import { gaugePath, Link } from '../router.tsx'
import { useUnit } from '../settings.ts'
import { t } from '../texts/texts.ts'

/** A plant with more gauges has rows instead of cards. */
const MOST_CARDS = 40

export interface GaugeProps {
  gauge: Gauge
  labels: GaugeLabels
  alarms: Alarm[]
  live: Live
  unit: Unit
}

export function Overview(): JSX.Element {
  const live = useLive()
  const unit = useUnit()
  const [filter, change] = useFilter()
  const { directory, error, query } = useDirectory()
  const { segments, gauges, alarms, plant: now } = useSnapshot()
  const { plant } = usePlant()
  const isLarge = gauges.length > MOST_CARDS
  const alarmsOf = ({ name }: Gauge): Alarm[] => alarms.alarms.filter(({ gauge }) => gauge === name)
  const isFiltered = hasFilter(filter)
  // A label that is not known yet hides no gauge as if it had another one.
  const isWaiting = directory === null && error === null && needsLabels(filter)
  const shown = gauges
    .map((gauge): GaugeProps => {
      const labels = labelsOf(directory, gauge.name)
      return { gauge, labels, alarms: alarmsOf(gauge), live, unit }
    })
    .filter(({ gauge, labels, alarms }) => !isFiltered || passesNow(filter, gauge, labels, alarms, live))
  return (
    <>
      <div class="bar overview-bar">
        <h1 class="visually-hidden">{t.pages['/']}</h1>
        <FilterFields filter={filter} change={change} directory={directory} />
        {isFiltered && !isWaiting && (
          <span class="muted" role="status">
            {t.overview.counted(shown.length, gauges.length)}
          </span>
        )}
        <Views page="/" directory={directory} />
        <Link to={`/wall${location.search}`}>{t.overview.wall}</Link>
      </div>
      {error && <QueryState of={[query]} />}
      <UnknownState />
      {!isFiltered && isLarge && <OtherAlarms alarms={alarms.alarms} gauges={gauges} />}
      {!isFiltered && !isLarge && <AlarmLines alarms={alarms.alarms} label={t.alarms.active} />}
      <FailingNotifications />
      <div class="beside-picture">
        {!isFiltered && plant && hasPicture(plant) && (
          <section class="overview-plant" aria-label={t.pages['/plant']}>
            <Story now={now} />
            <Picture plant={plant} />
          </section>
        )}
        <div>
          {isLarge ? (
            <Rows segments={segments} shown={shown} isFiltered={isFiltered} />
          ) : (
            <Cards segments={segments} shown={shown} />
          )}
        </div>
      </div>
      {segments.length === 0 && <p class="waiting">{t.overview.noSegments}</p>}
      {isWaiting && <QueryState of={[query]} loading={t.overview.waiting} />}
      {isFiltered && !isWaiting && shown.length === 0 && (
        <p class="muted">{filter.text === '' ? t.overview.noneFiltered : t.overview.noMatch(filter.text)}</p>
      )}
    </>
  )
}

function Cards({ segments, shown }: { segments: Segment[]; shown: GaugeProps[] }): JSX.Element {
  return (
    <>
      {segments.map((segment) => (
        <section class="segment" key={segment.name} aria-label={t.overview.segment(segment.name)}>
          <SegmentHeading segment={segment} />
          <div class="cards">
            {shown
              .filter(({ gauge }) => gauge.segment === segment.name)
              .map((props) => (
                <Card {...props} key={props.gauge.name} />
              ))}
          </div>
        </section>
      ))}
    </>
  )
}

/** The problems of all segments, then each segment; a segment is closed until the user opens it or searches. */
function Rows(props: { segments: Segment[]; shown: GaugeProps[]; isFiltered: boolean }): JSX.Element {
  const { segments, shown, isFiltered } = props
  const problems = shown.filter((one) => urgency(one) > 0).sort((one, other) => urgency(other) - urgency(one))
  return (
    <>
      {problems.length > 0 && (
        <section class="segment problems" aria-label={t.overview.problems}>
          <h2>{t.overview.problems}</h2>
          <RowList rows={problems} />
        </section>
      )}
      {segments.map((segment) => {
        const all = shown.filter(({ gauge }) => gauge.segment === segment.name)
        const quiet = all.filter((one) => urgency(one) === 0)
        if (isFiltered && quiet.length === 0) return null
        return <SegmentRows segment={segment} rows={quiet} all={all} isOpen={isFiltered} key={segment.name} />
      })}
    </>
  )
}

function SegmentRows(props: { segment: Segment; rows: GaugeProps[]; all: GaugeProps[]; isOpen: boolean }): JSX.Element {
  const { segment, rows, all, isOpen } = props
  const [opened, setOpened] = useState(false)
  const open = isOpen || opened
  return (
    <section class="segment" aria-label={t.overview.segment(segment.name)}>
      <details open={open} onToggle={(event) => !isOpen && setOpened(event.currentTarget.open)}>
        <summary>
          <SegmentHeading segment={segment} />{' '}
          <span class="muted">
            {t.overview.gauges(all.length)}
            {all.length > rows.length && t.overview.withProblems(all.length - rows.length)}
          </span>{' '}
          <SegmentRange gauges={all.map(({ gauge }) => gauge)} />
        </summary>
        {open && <RowList rows={rows} />}
      </details>
    </section>
  )
}

/** The lowest and the highest pressure of a segment. */
function SegmentRange({ gauges }: { gauges: Gauge[] }): JSX.Element | null {
  const live = useLive()
  const unit = useUnit()
  const range = pressureRange(gauges, live.since)
  return (
    range && (
      <span class="segment-range">
        <ReadingText {...range.lowest} unit={unit} /> {t.overview.to} <ReadingText {...range.highest} unit={unit} />
      </span>
    )
  )
}

function RowList({ rows }: { rows: GaugeProps[] }): JSX.Element {
  return (
    <ul class="rows">
      {rows.map((props) => (
        <Row {...props} key={props.gauge.name} />
      ))}
    </ul>
  )
}

/** How soon a user must look at a gauge; 0 if it has no problem. A lost connection is no problem of a gauge: the last known ones stay. */
export function urgency({ gauge, alarms }: Pick<GaugeProps, 'gauge' | 'alarms'>): number {
  const priorities = alarms.filter(isActive).map(({ priority }) => PRIORITIES.length - PRIORITIES.indexOf(priority))
  const hasProblem = gauge.state !== 'data-exchange' || isStale(gauge, 0)
  return Math.max(0, ...priorities) * 2 + Number(hasProblem)
}

function SegmentHeading({ segment }: { segment: Segment }): JSX.Element {
  return (
    <h2>
      {segment.name}
      {segment.problem && <span class="problem"> {segment.problem}</span>}
    </h2>
  )
}

function Row({ gauge, labels, alarms, live, unit }: GaugeProps): JSX.Element {
  const stale = isStale(gauge, live.since)
  return (
    <li class={stale ? 'row stale' : 'row'} data-gauge={gauge.name}>
      <Link to={gaugePath(gauge.name)}>{gauge.name}</Link>
      <span class="row-readings">
        {gauge.readings.map((reading) => (
          <span data-series={reading.series} key={reading.series}>
            <Channel gauge={gauge} reading={reading} />
            <ReadingText pa={boundOf(reading)} quality={currentQuality(gauge, reading, live.since)} unit={unit} />
          </span>
        ))}
        {gauge.kind === 'slave' && <Points gauge={gauge} live={live} />}
        {gauge.kind === 'gauge' && gauge.readings.length === 0 && (
          <span class="no-pressure stale">{t.common.noData}</span>
        )}
      </span>
      <GaugeStatus gauge={gauge} stale={stale} />
      <Overdue labels={labels} />
      <CardAlarms alarms={alarms} />
      {urgency({ gauge, alarms }) > 0 && <Faults gauge={gauge} />}
    </li>
  )
}

/** Which of several readings it is; nothing beside a single one. */
function Channel({ gauge, reading }: { gauge: Gauge; reading: Reading }): JSX.Element | null {
  if (gauge.readings.length < 2) return null
  return <span class="channel muted">{t.reading.channel(reading.instance)}</span>
}

function Card({ gauge, labels, alarms, live, unit }: GaugeProps): JSX.Element {
  const stale = isStale(gauge, live.since)
  const several = gauge.readings.length > 1
  return (
    <article class={`card ${stale ? 'stale' : ''} ${several ? 'several' : ''}`} data-gauge={gauge.name}>
      <div class="card-head">
        <h3>
          <Link to={gaugePath(gauge.name)}>{gauge.name}</Link>
        </h3>
        <GaugeStatus gauge={gauge} stale={stale} />
      </div>
      {gauge.readings.map((reading) => (
        <CardReading gauge={gauge} reading={reading} live={live} unit={unit} key={reading.series}>
          {several && <Sparkline series={reading.series} />}
        </CardReading>
      ))}
      {gauge.kind === 'slave' && <Points gauge={gauge} live={live} />}
      {gauge.kind === 'gauge' && gauge.readings.length === 0 && <p class="big none">{t.common.noData}</p>}
      <Faults gauge={gauge} />
      <CardAlarms alarms={alarms} />
      <Overdue labels={labels} />
      <p class="card-foot">
        <span class="device" title={gauge.device}>
          {gauge.device}
        </span>
        <Age gauge={gauge} live={live} />
      </p>
      {!several && gauge.readings[0] && <Sparkline series={gauge.readings[0].series} />}
    </article>
  )
}

interface CardReadingProps {
  gauge: Gauge
  reading: Reading
  live: Live
  unit: Unit
  /** The line of a channel. That of the only reading is below the card. */
  children: ComponentChildren
}

function CardReading({ gauge, reading, live, unit, children }: CardReadingProps): JSX.Element {
  const quality = currentQuality(gauge, reading, live.since)
  return (
    <div class="card-reading">
      <p class="big" data-series={reading.series}>
        <ReadingText pa={boundOf(reading)} quality={quality} unit={unit} />
      </p>
      <ReadingDetails gauge={gauge} reading={reading} quality={quality} unit={unit} />
      {children}
    </div>
  )
}
