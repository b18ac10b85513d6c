// The shares of the priorities among the raised alarms, beside those that ISA-18.2 and EEMUA 191 recommend.

import type { AlarmPerformance, Priority } from '../api/types.ts'
import { PRIORITIES } from './alarms.ts'

/** The recommended shares in percent. */
const RECOMMENDED: Record<Priority, number> = { high: 5, medium: 15, low: 80 }

/** The recommendation says *about*, in steps of five percent: what is nearer to the next step is beyond it. */
const TOLERANCE = 2.5

/** One of fewer alarms is more than five percent of them: their shares say nothing about the priorities. */
const LEAST_ALARMS = 20

/** The share of a priority. */
export interface Share {
  priority: Priority
  /** `null` without an alarm. */
  percent: number | null
  recommended: number
  /** Whether too many alarms have a priority that needs a quick response, or too few the lowest one. */
  isBeyond: boolean
}

/** The shares of all priorities, the highest first. */
export const sharesOf = ({ raised, by_priority }: Pick<AlarmPerformance, 'raised' | 'by_priority'>): Share[] =>
  PRIORITIES.map((priority) => {
    const recommended = RECOMMENDED[priority]
    const percent = raised === 0 ? null : (100 * by_priority[priority]) / raised
    const excess = (percent ?? recommended) - recommended
    const isBeyond = raised >= LEAST_ALARMS && (priority === 'low' ? -excess : excess) > TOLERANCE
    return { priority, percent, recommended, isBeyond }
  })
