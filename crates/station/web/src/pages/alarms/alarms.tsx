// The alarms page: active alarms, plant states, shelved alarms, those out of service and suppressed ones, all alarms, their history, their figures, and the
// webhooks that report them.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { fetchAlarms } from '../../api/calls.ts'
import type { Alarm } from '../../api/types.ts'
import { errorText, useQuery } from '../../components/hooks.ts'
import { AcknowledgeDialog } from './acknowledge-dialog.tsx'
import { ActiveAlarmList } from './active.tsx'
import { AllAlarms } from './all.tsx'
import { DefaultAlarms } from './default-alarms.tsx'
import { AlarmHistory } from './history.tsx'
import { Actions } from './item.tsx'
import { Performance } from './performance.tsx'
import { PlantStates } from './plant-states.tsx'
import { SettingsDialog } from './settings-dialog.tsx'
import { type Suppress, SuppressDialog } from './suppress-dialog.tsx'
import { OutOfServiceList, ShelvedList, SuppressedList } from './suppressed.tsx'
import { Webhooks } from './webhooks.tsx'

/** All alarms are fetched this often; every snapshot has the active ones. */
const REFRESH_MS = 2_000

const NONE: Alarm[] = []

export function Alarms(): JSX.Element {
  const [actions, setActions] = useState(0)
  const query = useQuery(`alarms ${actions}`, REFRESH_MS, (signal) => fetchAlarms(signal))
  const [error, setError] = useState<string | null>(null)
  const [chosen, setChosen] = useState<Suppress | null>(null)
  const [asked, setAsked] = useState<Alarm[] | null>(null)
  const [edited, setEdited] = useState<Alarm | null>(null)
  /** Runs an action, and fetches the alarms again when it has ended. */
  const run = (action: () => Promise<unknown>): void => {
    setError(null)
    action()
      .catch((error: unknown) => setError(errorText(error)))
      .finally(() => setActions((count) => count + 1))
  }
  const alarms = query.value ?? NONE
  return (
    <>
      <Actions>
        <ActiveAlarmList all={alarms} error={error} run={run} suppress={setChosen} ask={setAsked} edit={setEdited} />
      </Actions>
      <PlantStates alarms={alarms} actions={actions} run={run} />
      <Actions>
        <SuppressedList alarms={alarms} />
        <ShelvedList alarms={alarms} run={run} />
        <OutOfServiceList alarms={alarms} run={run} />
        <AllAlarms query={query} suppress={setChosen} edit={setEdited} />
      </Actions>
      <DefaultAlarms done={() => setActions((count) => count + 1)} />
      <AlarmHistory />
      <Performance />
      <Webhooks />
      {chosen && <SuppressDialog suppress={chosen} run={run} close={() => setChosen(null)} />}
      {asked && <AcknowledgeDialog alarms={asked} run={run} close={() => setAsked(null)} />}
      {edited && (
        <SettingsDialog
          alarm={edited}
          done={() => setActions((count) => count + 1)}
          close={() => setEdited(null)}
          key={edited.name}
        />
      )}
    </>
  )
}
