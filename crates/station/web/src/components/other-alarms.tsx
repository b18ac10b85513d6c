// The active alarms of no gauge: of a segment, of the station.

import './other-alarms.css'
import type { JSX } from 'preact'
import type { Alarm, Gauge } from '../api/types.ts'
import { conditionText } from '../lib/alarms.ts'
import { otherAlarms } from '../lib/wall.ts'
import { useUnit } from '../settings.ts'
import { t } from '../texts/texts.ts'
import { PriorityMark } from './alarm-marks.tsx'

export function OtherAlarms(props: { alarms: Alarm[]; gauges: Gauge[] }): JSX.Element | null {
  const unit = useUnit()
  const { lines, more } = otherAlarms(props.alarms, props.gauges)
  if (lines.length === 0) return null
  return (
    <ul class="other-alarms" aria-label={t.wall.others}>
      {lines.map((alarm) => (
        <li key={alarm.name}>
          <PriorityMark priority={alarm.priority} active={true} /> <strong>{alarm.name}</strong>{' '}
          <span class="condition">{conditionText(alarm, unit)}</span>
        </li>
      ))}
      {more > 0 && <li>{t.wall.more(more).trim()}</li>}
    </ul>
  )
}
