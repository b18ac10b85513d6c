// The present readings of one gauge.

import './readings.css'
import type { JSX } from 'preact'
import type { Gauge, GaugeLabels, Reading } from '../../api/types.ts'
import { GaugeStatus } from '../../components/bus-status.tsx'
import { labelsOf, Overdue, useDirectory } from '../../components/gauge-filter.tsx'
import { Points } from '../../components/points.tsx'
import { boundOf, ReadingDetails, ReadingText } from '../../components/pressure.tsx'
import { QueryState } from '../../components/query-state.tsx'
import { Age, Faults } from '../../components/reading-state.tsx'
import { Sparkline } from '../../components/sparkline.tsx'
import { currentQuality, isStale } from '../../lib/stale.ts'
import { useLive } from '../../live.ts'
import { Link } from '../../router.tsx'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'

export function Readings({ gauge }: { gauge: Gauge }): JSX.Element {
  const live = useLive()
  const stale = isStale(gauge, live.since)
  const { directory, error, query } = useDirectory()
  return (
    <section class={`panel readings ${stale ? 'stale' : ''}`} aria-label={t.gauge.readings}>
      <div class="readings-head">
        <h2>{gauge.name}</h2>
        <GaugeStatus gauge={gauge} stale={stale} />
        <span class="muted">
          {gauge.device} · {gauge.segment} · {t.common.address(gauge.address)}
        </span>
        <Age gauge={gauge} live={live} />
      </div>
      <div class="readings-list">
        {gauge.readings.map((reading) => (
          <LargeReading gauge={gauge} reading={reading} key={reading.series} />
        ))}
        {gauge.kind === 'slave' && <Points gauge={gauge} live={live} />}
        {gauge.kind === 'gauge' && gauge.readings.length === 0 && <p class="big none">{t.common.noData}</p>}
      </div>
      <Faults gauge={gauge} />
      {error && <QueryState of={[query]} />}
      <Labels labels={labelsOf(directory, gauge.name)} />
    </section>
  )
}

/** What the station's file says about the gauge; nothing without labels. A group, tag and location leads to its gauges. */
function Labels({ labels }: { labels: GaugeLabels }): JSX.Element | null {
  const { group, tags, location, calibrated, calibration_due: due } = labels
  if (!group && tags.length === 0 && !location && !calibrated) return null
  const link = (key: 'group' | 'tag' | 'location', value: string): JSX.Element => (
    <Link to={`/?${new URLSearchParams([[key, value]])}`} key={value}>
      {value}
    </Link>
  )
  return (
    <dl class="gauge-labels">
      {group && (
        <>
          <dt>{t.filter.group}</dt>
          <dd>{link('group', group)}</dd>
        </>
      )}
      {tags.length > 0 && (
        <>
          <dt>{t.gauge.tags}</dt>
          <dd class="tags">{tags.map((tag) => link('tag', tag))}</dd>
        </>
      )}
      {location && (
        <>
          <dt>{t.filter.location}</dt>
          <dd>{link('location', location)}</dd>
        </>
      )}
      {calibrated && (
        <>
          <dt>{t.gauge.calibrated}</dt>
          <dd>
            {calibrated}
            {due && t.gauge.validUntil(due)} <Overdue labels={labels} />
          </dd>
        </>
      )}
    </dl>
  )
}

function LargeReading({ gauge, reading }: { gauge: Gauge; reading: Reading }): JSX.Element {
  const unit = useUnit()
  const { since } = useLive()
  const quality = currentQuality(gauge, reading, since)
  return (
    <div>
      <p class="big">
        <ReadingText pa={boundOf(reading)} quality={quality} unit={unit} />
      </p>
      <ReadingDetails gauge={gauge} reading={reading} quality={quality} unit={unit} />
      <Sparkline series={reading.series} />
    </div>
  )
}
