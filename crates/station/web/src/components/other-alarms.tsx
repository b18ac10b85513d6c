// Active alarms as lines, the most urgent first: those of no gauge, such as that of a segment, or those of all gauges too.

import './other-alarms.css'
import type { JSX } from 'preact'
import type { Alarm, Gauge } from '../api/types.ts'
import { useLanguage } from '../language.ts'
import { conditionText } from '../lib/alarms.ts'
import { readable } from '../lib/format.ts'
import { alarmLines, hasNoGauge } from '../lib/wall.ts'
import { gaugePath, Link } from '../router.tsx'
import { useUnit } from '../settings.ts'
import { t } from '../texts/texts.ts'
import { PriorityMark } from './alarm-marks.tsx'

/** The alarms that stand beside no gauge. */
export function OtherAlarms({ alarms, gauges }: { alarms: Alarm[]; gauges: Gauge[] }): JSX.Element | null {
  return <AlarmLines alarms={alarms.filter((alarm) => hasNoGauge(alarm, gauges))} label={t.wall.others} />
}

export function AlarmLines({ alarms, label }: { alarms: Alarm[]; label: string }): JSX.Element | null {
  const { lines, more } = alarmLines(alarms)
  if (lines.length === 0) return null
  return (
    <ul class="other-alarms" aria-label={label}>
      {lines.map((alarm) => (
        <Line alarm={alarm} key={alarm.name} />
      ))}
      <More count={more} width="wide" />
      <More count={lines.length - 1 + more} width="narrow" />
    </ul>
  )
}

/** How many alarms have no line. A phone shows one line only. */
function More({ count, width }: { count: number; width: 'wide' | 'narrow' }): JSX.Element | null {
  if (count === 0) return null
  return (
    <li class={`more ${width}`}>
      <Link to="/alarms">{t.wall.more(count).trim()}</Link>
    </li>
  )
}

function Line({ alarm }: { alarm: Alarm }): JSX.Element {
  const { name, priority, gauge, condition, text } = alarm
  const unit = useUnit()
  // The station says in English which fault it is. The name of an alarm about a point is its condition: its text has the value.
  const isEnglish = useLanguage() === 'en'
  const isStations = text !== '' && (condition === 'point' || (condition === 'fault' && isEnglish))
  return (
    <li>
      <PriorityMark priority={priority} active={true} />{' '}
      <strong>{gauge ? <Link to={gaugePath(gauge)}>{name}</Link> : name}</strong>{' '}
      {isStations ? (
        <span class="condition" lang="en">
          {readable(text)}
        </span>
      ) : (
        <span class="condition">{conditionText(alarm, unit)}</span>
      )}
    </li>
  )
}
