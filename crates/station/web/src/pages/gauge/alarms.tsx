// The standing alarms of one gauge, its alarm limits, and the levels of the station's file.

import './alarms.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { fetchAlarms } from '../../api/calls.ts'
import type { Alarm, Gauge } from '../../api/types.ts'
import { errorText, useQuery } from '../../components/hooks.ts'
import { QueryState } from '../../components/query-state.tsx'
import { limitsOf, quantity } from '../../lib/alarms.ts'
import { day } from '../../lib/format.ts'
import { useLive, useSnapshot } from '../../live.ts'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'
import { Actions } from '../alarms/item.tsx'
import { AlarmHead, AlarmLine } from '../alarms/line.tsx'
import { SettingsDialog } from '../alarms/settings-dialog.tsx'
import { type Suppress, SuppressDialog } from '../alarms/suppress-dialog.tsx'
import { AlarmLimits } from '../trends/limits.tsx'

const REFRESH_MS = 5_000

export function GaugeAlarms({ gauge }: { gauge: Gauge }): JSX.Element {
  const { alarms } = useSnapshot()
  const { now, connected } = useLive()
  const unit = useUnit()
  const query = useQuery('alarms', REFRESH_MS, (signal) => fetchAlarms(signal))
  const [openLines, setOpenLines] = useState<readonly string[]>([])
  const [error, setError] = useState<string | null>(null)
  const [chosen, setChosen] = useState<Suppress | null>(null)
  const [edited, setEdited] = useState<Alarm | null>(null)
  const run = (action: () => Promise<unknown>): void => {
    setError(null)
    action().catch((error: unknown) => setError(errorText(error)))
  }
  const series = gauge.readings.map(({ series }) => series)
  const standing = alarms.alarms.filter((alarm) => alarm.gauge === gauge.name || isAboutOne(alarm, series))
  const limits = limitsOf(query.value ?? [], series)
  return (
    <section class="panel active-alarms gauge-alarms" aria-label={t.gauge.alarms}>
      <h2>{t.gauge.alarms}</h2>
      {error && (
        <p class="error" role="alert">
          {error}
        </p>
      )}
      {standing.length === 0 ? <p class="muted">{t.alarms.noneActive}</p> : <AlarmHead />}
      <Actions>
        <ul class="alarm-list">
          {standing.map((alarm) => (
            <AlarmLine
              alarm={alarm}
              value={alarm.value}
              isGone={false}
              isTicked={false}
              isOpen={openLines.includes(alarm.name)}
              connected={connected}
              now={now}
              today={day(now)}
              run={run}
              suppress={setChosen}
              edit={setEdited}
              open={(isOpen) =>
                setOpenLines((before) => [
                  ...before.filter((name) => name !== alarm.name),
                  ...(isOpen ? [alarm.name] : []),
                ])
              }
              key={alarm.name}
            />
          ))}
        </ul>
      </Actions>
      <QueryState of={[query]} empty={limits.length === 0 && t.gauge.noLimits} />
      <AlarmLimits limits={limits} unit={unit} />
      {gauge.levels.length > 0 && (
        <dl class="gauge-levels">
          {gauge.levels.map(({ name, pa }) => (
            <div key={name}>
              <dt>{name}</dt>
              <dd>{quantity(pa, 'Pa', unit)}</dd>
            </div>
          ))}
        </dl>
      )}
      {chosen && <SuppressDialog suppress={chosen} run={run} close={() => setChosen(null)} />}
      {edited && <SettingsDialog alarm={edited} done={() => {}} close={() => setEdited(null)} key={edited.name} />}
    </section>
  )
}

/** Whether an alarm about several series is about one of these. */
const isAboutOne = ({ several }: Alarm, series: string[]): boolean =>
  several?.series.some((one) => series.includes(one)) ?? false
