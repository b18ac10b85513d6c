// The points of a slave: numbers with units, codes and bits in the words of the station's file.

import './points.css'
import type { JSX } from 'preact'
import type { Gauge, Point } from '../api/types.ts'
import { pointCause, pointText } from '../lib/points.ts'
import { isStale } from '../lib/stale.ts'
import type { Live } from '../live.ts'
import { t } from '../texts/texts.ts'

/** All points of a slave with their values. */
export function Points({ gauge, live }: { gauge: Gauge; live: Live }): JSX.Element {
  const stale = isStale(gauge, live.since)
  return (
    <dl class="points">
      {gauge.parameters.map((point) => (
        <PointValue point={point} stale={stale} key={point.target} />
      ))}
    </dl>
  )
}

function PointValue({ point, stale }: { point: Point; stale: boolean }): JSX.Element {
  const text = pointText(point, stale)
  const cause = pointCause(point)
  return (
    <>
      <dt title={point.name}>{point.target}</dt>
      <dd
        class={text === null ? 'no-pressure stale' : undefined}
        data-point={point.target}
        data-quality={point.quality}
      >
        {text ?? (cause === null ? t.common.noData : `${t.common.noData}: ${cause}`)}
      </dd>
    </>
  )
}
