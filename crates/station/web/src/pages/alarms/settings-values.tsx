// The values with which an engineer compares the settings of an alarm: what it watches now, and where it ends.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import type { Alarm } from '../../api/types.ts'
import { FirstFew } from '../../components/first-few.tsx'
import { ReadingText } from '../../components/pressure.tsx'
import { Unbroken } from '../../components/unbroken.tsx'
import { type Reset, type Watched, watchedPressures } from '../../lib/alarm-settings.ts'
import { quantity } from '../../lib/alarms.ts'
import { clock } from '../../lib/format.ts'
import { live } from '../../live.ts'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'

/** What an alarm watches, at one time. */
interface Seen {
  time: string
  pressures: Watched[]
  /** In decades per minute, of an alarm about a rise. */
  rise: number | null
}

interface Props {
  alarm: Alarm
  /** `null` while the fields name none. */
  reset: Reset | null
}

/** The values at the time when the dialog opens do not move while they are read; the reset value follows the fields. */
export function SettingsValues({ alarm, reset }: Props): JSX.Element {
  const [{ time, pressures, rise }] = useState(() => seenNow(alarm))
  return (
    <div class="values">
      {pressures.length > 0 && (
        <FirstFew items={pressures} draw={(some) => <Pressures pressures={some} time={time} />} />
      )}
      <dl class="facts">
        {rise !== null && <Rise series={alarm.series ?? ''} rise={rise} time={time} />}
        <ResetValue reset={reset} />
      </dl>
    </div>
  )
}

function seenNow(alarm: Alarm): Seen {
  const { snapshot, since, connected, now } = live()
  const time = clock(now)
  if (!snapshot || !connected) return { time, pressures: [], rise: null }
  const rise = alarm.condition === 'rise' ? alarm.value : null
  return { time, pressures: watchedPressures(alarm, snapshot.gauges, since), rise }
}

function Pressures({ pressures, time }: Pick<Seen, 'pressures' | 'time'>): JSX.Element {
  const unit = useUnit()
  return (
    <dl class="facts">
      {pressures.map(({ series, pa, quality }) => (
        <div key={series}>
          <dt>
            <Unbroken text={t.alarmSettings.pressureAt(series, time)} />
          </dt>
          <dd>
            <ReadingText pa={pa} quality={quality} unit={unit} />
            {quality !== 'valid' && <span class="muted"> {t.qualities[quality]}</span>}
          </dd>
        </div>
      ))}
    </dl>
  )
}

function Rise({ series, rise, time }: { series: string; rise: number; time: string }): JSX.Element {
  const unit = useUnit()
  return (
    <div>
      <dt>
        <Unbroken text={t.alarmSettings.riseAt(series, time)} />
      </dt>
      <dd>{quantity(rise, 'decades/min', unit)}</dd>
    </div>
  )
}

/** Keeps its place while there is no value: the fields below do not move under the cursor. */
function ResetValue({ reset }: { reset: Reset | null }): JSX.Element {
  const unit = useUnit()
  return (
    <div class={reset ? 'reset-value' : 'reset-value no-value'} aria-live="polite" aria-atomic="true">
      <dt>{t.alarmSettings.resetValue}</dt>
      <dd>{reset ? quantity(reset.value, reset.unit, unit) : '–'}</dd>
    </div>
  )
}
