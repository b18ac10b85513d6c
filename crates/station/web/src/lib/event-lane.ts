// Events in a lane below a chart: those that are close to each other share a mark.

import type { StationEvent } from '../api/types.ts'

/** Events that share a mark. */
export interface EventGroup {
  /** The time of the earliest. */
  at_ms: number
  /** Where the mark is, 0 at the left edge of the window to 1 at the right. */
  position: number
  /** The earliest first. */
  events: StationEvent[]
}

/** The events of a window as groups that are at least `widthPx` apart on a lane of `lanePx`. */
export function eventGroups(
  events: StationEvent[],
  [from, to]: [number, number],
  lanePx: number,
  widthPx: number,
): EventGroup[] {
  const reach = ((to - from) * widthPx) / Math.max(1, lanePx)
  const shown = events.filter(({ at_ms }) => at_ms >= from && at_ms <= to).sort((one, two) => one.at_ms - two.at_ms)
  const groups: EventGroup[] = []
  for (const event of shown) {
    const { at_ms } = event
    const last = groups.at(-1)
    if (last && at_ms - last.at_ms < reach) last.events.push(event)
    else groups.push({ at_ms, position: (at_ms - from) / (to - from), events: [event] })
  }
  return groups
}
