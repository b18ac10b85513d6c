// The names of the alarm limits that are lines in the chart.

import './limits.css'
import type { JSX } from 'preact'
import { PriorityMark } from '../../components/alarm-marks.tsx'
import { isActive, type PressureLimit, quantity } from '../../lib/alarms.ts'
import type { Unit } from '../../lib/units.ts'
import { t } from '../../texts/texts.ts'

export function AlarmLimits({ limits, unit }: { limits: PressureLimit[]; unit: Unit }): JSX.Element | null {
  if (limits.length === 0) return null
  return (
    <ul class="limits" aria-label={t.trends.limits}>
      {limits.map(({ name, priority, state, condition, limit }) => (
        <li key={name} data-limit={name}>
          <PriorityMark priority={priority} active={isActive({ state })} /> {name}{' '}
          <span class="muted">{`${t.alarms.limitOf[condition]} ${quantity(limit, 'Pa', unit)}`}</span>
        </li>
      ))}
    </ul>
  )
}
