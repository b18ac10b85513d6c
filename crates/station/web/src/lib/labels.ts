// Words for what the API says in codes, and for the state of a segment and the recorder.

import type { AlarmState, AuditEntry, Recorder, Segment } from '../api/types.ts'
import { t } from '../texts/texts.ts'
import { withLocalTimes } from './format.ts'

const GASES: Record<string, string> = { n2: 'N₂', h2: 'H₂', co2: 'CO₂', h2o: 'H₂O', o2: 'O₂', co: 'CO' }

export function gas(name: string): string {
  const code = name.toLowerCase()
  if (code === 'air') return t.reading.air
  return GASES[code] ?? name.charAt(0).toUpperCase() + name.slice(1)
}

export function baud(bitsPerSecond: number): string {
  return bitsPerSecond >= 1e6 ? `${bitsPerSecond / 1e6} Mbit/s` : `${bitsPerSecond / 1e3} kbit/s`
}

/** Why the recorder does not write, or what is damaged in its database, in a sentence; `null` if all is well. */
export function recorderProblem({ error, damage }: Recorder): string | null {
  if (error) return t.app.recorder(error)
  return damage ? t.app.damaged(damage) : null
}

/** The number of samples and events that the recorder lost, in one sentence; `null` if it lost none. */
export function lostSentence({ lost_samples, lost_events }: Recorder): string | null {
  return lost_samples + lost_events > 0 ? t.app.notRecorded(lost_samples, lost_events) : null
}

/** The value before and after an entry of the audit trail; states of alarms in the language of the page. */
export function changeText({ action, before, after }: Pick<AuditEntry, 'action' | 'before' | 'after'>): string {
  // A key of the station's file without a value is not in the file. Without both the entry counts more keys.
  if (action === 'file-changed' && (before ?? after) !== null) {
    return `${before ?? t.audit.notInFile} → ${after ?? t.audit.notInFile}`
  }
  const text = (value: string): string =>
    Object.hasOwn(t.alarms.states, value) ? t.alarms.states[value as AlarmState].label : withLocalTimes(value)
  const changed = after === null ? t.common.unknown : text(after)
  return before === null ? (after === null ? '' : changed) : `${text(before)} → ${changed}`
}

/** The number of stations that the sentence about a segment names. */
const MOST_NAMED = 3

/** The state of a segment, in one sentence. */
export function segmentSentence(segment: Segment): string {
  if (segment.problem) return t.bus.notWorking(segment.problem)
  if (segment.state !== 'running') return t.bus.segmentIs(t.segmentStates[segment.state])
  const others = segment.stations.filter(({ state }) => ['missing', 'fault', 'starting'].includes(state))
  if (others.length === 0) return t.bus.allExchange
  const named = others
    .slice(0, MOST_NAMED)
    .map(({ name, address, description }) => `${name ?? address}: ${description}`)
  const more = others.length > MOST_NAMED ? [t.common.andMore(others.length - MOST_NAMED)] : []
  return `${[...named, ...more].join('; ')}.`
}
