// The present readings of one gauge.

import './readings.css'
import type { JSX } from 'preact'
import type { Gauge, Reading } from '../../api/types.ts'
import { BusStatusMark } from '../../components/bus-status.tsx'
import { boundOf, ReadingDetails, ReadingText } from '../../components/pressure.tsx'
import { Age, Faults } from '../../components/reading-state.tsx'
import { Sparkline } from '../../components/sparkline.tsx'
import { currentQuality, isStale } from '../../lib/stale.ts'
import { useLive } from '../../live.ts'
import { useUnit } from '../../settings.ts'

export function Readings({ gauge }: { gauge: Gauge }): JSX.Element {
  const live = useLive()
  const stale = isStale(gauge, live.since)
  return (
    <section class={`panel readings ${stale ? 'stale' : ''}`} aria-label="Readings">
      <div class="readings-head">
        <h2>{gauge.name}</h2>
        <BusStatusMark status={gauge.state} stale={stale && gauge.state === 'data-exchange'} />
        <span class="muted">
          {gauge.device} · {gauge.segment} · address {gauge.address}
        </span>
        <Age gauge={gauge} live={live} />
      </div>
      <div class="readings-list">
        {gauge.readings.map((reading) => (
          <LargeReading gauge={gauge} reading={reading} stale={stale} key={reading.series} />
        ))}
        {gauge.readings.length === 0 && <p class="big none">no data</p>}
      </div>
      <Faults gauge={gauge} />
    </section>
  )
}

function LargeReading({ gauge, reading, stale }: { gauge: Gauge; reading: Reading; stale: boolean }): JSX.Element {
  const unit = useUnit()
  const { since } = useLive()
  const quality = currentQuality(gauge, reading, since)
  return (
    <div>
      <p class="big">
        <ReadingText pa={boundOf(reading)} quality={quality} unit={unit} />
      </p>
      <ReadingDetails gauge={gauge} reading={reading} quality={quality} unit={unit} />
      <Sparkline series={reading.series} stale={stale} />
    </div>
  )
}
