// The sound of alarms: which priority sounds, with which tones, and which occurrences a user has silenced.

import type { Alarm, Priority } from '../api/types.ts'
import { PRIORITIES } from './alarms.ts'

/** A tone that is repeated. Each priority has another pitch, number of pulses and pause, so that it is known without a look. */
export interface Tone {
  hertz: number
  pulses: number
  /** From the begin of one repetition to that of the next. */
  everyMs: number
}

/** chosen: the more urgent, the higher, the more pulses and the shorter the pause. */
export const TONES: Record<Priority, Tone> = {
  high: { hertz: 880, pulses: 3, everyMs: 3_000 },
  medium: { hertz: 660, pulses: 2, everyMs: 6_000 },
  low: { hertz: 440, pulses: 1, everyMs: 12_000 },
}

/** A pulse, and from the begin of one to that of the next, in seconds. */
export const PULSE_S = 0.15
export const NEXT_PULSE_S = 0.25

type Heard = Pick<Alarm, 'name' | 'occurrence' | 'priority' | 'state'>

/** An alarm that is raised again sounds again. */
const keyOf = ({ name, occurrence }: Heard): string => `${occurrence} ${name}`

/** Active alarms that are not acknowledged. */
const loud = (alarms: readonly Heard[]): Heard[] => alarms.filter(({ state }) => state === 'unacknowledged')

/** The highest priority that sounds; `null` for silence. */
export function soundingPriority(alarms: readonly Heard[], silenced: ReadonlySet<string>): Priority | null {
  const heard = loud(alarms).filter((alarm) => !silenced.has(keyOf(alarm)))
  return PRIORITIES.find((priority) => heard.some((alarm) => alarm.priority === priority)) ?? null
}

/** The occurrences that are silent after a user has silenced these alarms. Those of before that have ended are forgotten. */
export const silencing = (alarms: readonly Heard[]): ReadonlySet<string> => new Set(loud(alarms).map(keyOf))

/** The silenced occurrences as the browser keeps them; none if the text is not a list of them. */
export function silencedOf(text: string | null): ReadonlySet<string> {
  try {
    const kept: unknown = JSON.parse(text ?? '[]')
    return new Set(Array.isArray(kept) ? kept.filter((one) => typeof one === 'string') : [])
  } catch {
    return new Set()
  }
}
