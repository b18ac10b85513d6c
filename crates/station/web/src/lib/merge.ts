// The state of the station, kept up to date by the changes of the live stream.

import type { LiveState, Snapshot } from '../api/types.ts'
import { byUrgency } from './alarms.ts'

/** The entries with those of a change; `null` removes one. */
function withEntries<T>(entries: Record<string, T>, change: Record<string, T | null>): Record<string, T> {
  const made = new Map(Object.entries(entries))
  for (const [name, entry] of Object.entries(change)) {
    if (entry === null) made.delete(name)
    else made.set(name, entry)
  }
  return Object.fromEntries(made)
}

/**
 * The state after a change, which has whole parts, and of the parts `byName` the entries that have changed. The old state stays as it is,
 * and an entry without a change stays the same object.
 */
export function changed<T extends object, K extends keyof T>(state: T, change: Partial<T>, byName: K[]): T {
  const made = { ...state, ...change }
  for (const name of byName) {
    const [entries, changes] = [state[name], change[name]]
    if (changes) made[name] = withEntries(entries as Record<string, unknown>, changes) as T[K]
  }
  return made
}

/** The state with lists instead of objects. */
export function snapshotOf({ gauges, gauge_order, segments, alarms, standing_alarms, ...rest }: LiveState): Snapshot {
  const inOrder = gauge_order.flatMap((name) => {
    const gauge = Object.hasOwn(gauges, name) ? gauges[name] : undefined
    return gauge ? [gauge] : []
  })
  const standing = Object.values(standing_alarms).sort(byUrgency)
  return { ...rest, segments: Object.values(segments), gauges: inOrder, alarms: { ...alarms, alarms: standing } }
}
