// The state of the station as its pages use it.

import type { LiveState, Snapshot } from '../api/types.ts'
import { byUrgency } from './alarms.ts'

/** The state with lists instead of objects. */
export function snapshotOf({ gauges, gauge_order, segments, alarms, standing_alarms, ...rest }: LiveState): Snapshot {
  const inOrder = gauge_order.flatMap((name) => {
    const gauge = Object.hasOwn(gauges, name) ? gauges[name] : undefined
    return gauge ? [gauge] : []
  })
  const standing = Object.values(standing_alarms).sort(byUrgency)
  return { ...rest, segments: Object.values(segments), gauges: inOrder, alarms: { ...alarms, alarms: standing } }
}
