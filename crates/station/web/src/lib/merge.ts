// The state of the station, kept up to date by the changes of the live stream.

import type { Gauge, LiveGauge, LiveState, Snapshot } from '../api/types.ts'

type JsonObject = Record<string, unknown>

const isObject = (value: unknown): value is JsonObject =>
  typeof value === 'object' && value !== null && !Array.isArray(value)

/**
 * Applies a JSON merge patch (RFC 7396) and leaves the target unchanged; parts without a change stay the same objects. A property that the
 * RFC would remove becomes `null`, because the properties of the API are `null` without a value.
 */
export function merged(target: unknown, patch: unknown): unknown {
  if (!isObject(patch)) return patch
  const old = isObject(target) ? target : {}
  const made = new Map(Object.entries(old))
  for (const [key, value] of Object.entries(patch)) made.set(key, merged(made.get(key), value))
  return Object.fromEntries(made)
}

/** The entries of an object that were not removed. */
function present<T>(entries: Record<string, T>): T[] {
  return Object.values(entries).filter((entry) => entry !== null)
}

/** The same without the entries that were removed. */
function withoutNull<T>(entries: Record<string, T>): Record<string, T> {
  return Object.fromEntries(Object.entries(entries).filter(([, entry]) => entry !== null))
}

/** The gauges that were converted before: a gauge without a change is the same object. */
const converted = new WeakMap<LiveGauge, Gauge>()

function gaugeOf(gauge: LiveGauge): Gauge {
  const known = converted.get(gauge)
  if (known) return known
  const readings = present(gauge.readings).sort((one, other) => one.instance - other.instance)
  const made = { ...gauge, readings }
  converted.set(gauge, made)
  return made
}

/** The state with lists instead of objects. */
export function snapshotOf({ gauges, gauge_order, segments, alarms, plant, ...rest }: LiveState): Snapshot {
  const { order, alarms: active, ...counts } = alarms
  const inOrder = <T>(names: string[], all: Record<string, T>): T[] =>
    names.flatMap((name) => (Object.hasOwn(all, name) && all[name] ? [all[name]] : []))
  return {
    ...rest,
    plant: { ...plant, states: withoutNull(plant.states) },
    segments: present(segments),
    gauges: inOrder(gauge_order, gauges).map(gaugeOf),
    alarms: { ...counts, alarms: inOrder(order, active) },
  }
}
