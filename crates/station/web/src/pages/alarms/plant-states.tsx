// The plant states of the station's file: which are declared, and the dialog that declares, extends or ends one.

import './plant-states.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { declarePlantState, endPlantState, extendPlantState, fetchPlantStates } from '../../api/calls.ts'
import type { Alarm, DeclaredPlantState, PlantState } from '../../api/types.ts'
import { PriorityMark } from '../../components/alarm-marks.tsx'
import { FirstFew } from '../../components/first-few.tsx'
import { FormEnd, ReasonField } from '../../components/form-dialog.tsx'
import { useModal, useQuery } from '../../components/hooks.ts'
import { QueryState } from '../../components/query-state.tsx'
import { Unbroken } from '../../components/unbroken.tsx'
import { isActive } from '../../lib/alarms.ts'
import { alarmCount, durationsUpTo, type NamedAlarm, suppressedBy } from '../../lib/plant-states.ts'
import { useLive } from '../../live.ts'
import { hasRole, useSession } from '../../session.ts'
import { t } from '../../texts/texts.ts'
import { Actions, type RunAction, shortTime } from './item.tsx'

/** The plant states are fetched this often; every snapshot has the declared ones. */
const REFRESH_MS = 10_000

type Kind = 'declare' | 'extend' | 'end'

interface Chosen {
  kind: Kind
  state: PlantState
}

interface Props {
  /** All alarms, as they were fetched last. */
  alarms: Alarm[]
  /** Changes after every action of this page. */
  actions: number
  run: RunAction
}

export function PlantStates({ alarms, actions, run }: Props): JSX.Element | null {
  const query = useQuery(`plant states ${actions}`, REFRESH_MS, (signal) => fetchPlantStates(signal))
  const [chosen, setChosen] = useState<Chosen | null>(null)
  const declared = useLive().snapshot?.alarms.plant_states ?? []
  if (query.value === null ? query.error === null : query.value.length === 0) return null
  return (
    <section class="panel" aria-label={t.plantStates.title}>
      <h2>{t.plantStates.title}</h2>
      <QueryState of={[query]} />
      <Actions>
        <ul class="plant-states">
          {query.value?.map((state) => (
            <Item
              state={state}
              declared={declared.find(({ name }) => name === state.name) ?? null}
              choose={(kind) => setChosen({ kind, state })}
              key={state.name}
            />
          ))}
        </ul>
      </Actions>
      {chosen && <PlantStateDialog chosen={chosen} alarms={alarms} run={run} close={() => setChosen(null)} />}
    </section>
  )
}

interface ItemProps {
  state: PlantState
  declared: DeclaredPlantState | null
  choose: (kind: Kind) => void
}

function Item({ state, declared, choose }: ItemProps): JSX.Element {
  const { now } = useLive()
  const session = useSession()
  const mayDeclare = hasRole(session, state.role)
  const { name, description } = state
  return (
    <li data-plant-state={name} class={declared ? 'declared' : undefined}>
      <div class="description">
        <strong>{name}</strong>{' '}
        <span class="state">{declared ? t.plantStates.declared : t.plantStates.notDeclared}</span>
        {description && <p>{description}</p>}
        {declared && (
          <>
            {/* Without its label a reason reads like a contradiction to the description. */}
            <p>
              {t.common.reason}: {declared.reason}
            </p>
            <p class="muted">
              {declared.user}, {shortTime(declared.at_ms, now)}, {t.alarms.until(shortTime(declared.until_ms, now))}
            </p>
          </>
        )}
        <details>
          <summary>{(declared ? t.plantStates.suppresses : t.plantStates.wouldSuppress)(alarmCount(state))}</summary>
          <p class="muted">{state.alarms.join(', ')}</p>
        </details>
      </div>
      <div class="actions">
        {mayDeclare && !declared && <Button kind="declare" name={name} press={choose} />}
        {mayDeclare && declared && <Button kind="extend" name={name} press={choose} />}
        {declared && hasRole(session, 'operator') && <Button kind="end" name={name} press={choose} />}
      </div>
    </li>
  )
}

function Button({ kind, name, press }: { kind: Kind; name: string; press: (kind: Kind) => void }): JSX.Element {
  const { verb } = t.plantStates.kinds[kind]
  return (
    <button type="button" aria-label={`${verb}: ${name}`} onClick={() => press(kind)}>
      {verb} …
    </button>
  )
}

interface DialogProps {
  chosen: Chosen
  alarms: Alarm[]
  run: RunAction
  close: () => void
}

function PlantStateDialog({ chosen: { kind, state }, alarms, run, close }: DialogProps): JSX.Element {
  const dialog = useModal()
  const durations = durationsUpTo(state.longest_minutes)
  const [reason, setReason] = useState('')
  const [minutes, setMinutes] = useState(durations[0]?.[1] ?? state.longest_minutes)
  const { verb, title, sentence } = t.plantStates.kinds[kind]
  const submit = (event: Event): void => {
    event.preventDefault()
    run(() => change(kind, state.name, reason.trim(), minutes))
    close()
  }
  return (
    <dialog ref={dialog} onClose={close} aria-label={title} class="form-dialog plant-state-dialog">
      <h2>
        {verb}: {state.name}
      </h2>
      {state.description && <p>{state.description}</p>}
      <p class="muted">{sentence(alarmCount(state))}</p>
      <FirstFew items={suppressedBy(state, alarms)} draw={(some) => <AlarmNames alarms={some} />} />
      <form onSubmit={submit}>
        <ReasonField reason={reason} setReason={setReason} isOptional={kind === 'end'} />
        {kind !== 'end' && (
          <label>
            {t.suppress.duration}
            <select value={minutes} onChange={(event) => setMinutes(Number(event.currentTarget.value))}>
              {durations.map(([label, minutes]) => (
                <option value={minutes} key={minutes}>
                  {label}
                </option>
              ))}
            </select>
          </label>
        )}
        <FormEnd submit={verb} close={close} />
      </form>
    </dialog>
  )
}

function AlarmNames({ alarms }: { alarms: NamedAlarm[] }): JSX.Element {
  return (
    <ul class="alarm-names">
      {alarms.map(({ name, alarm }) => (
        <li key={name}>
          {alarm && <PriorityMark priority={alarm.priority} active={isActive(alarm)} />} <Unbroken text={name} />{' '}
          {alarm && isActive(alarm) && <strong>{t.plantStates.active}</strong>}
        </li>
      ))}
    </ul>
  )
}

function change(kind: Kind, name: string, reason: string, minutes: number): Promise<PlantState> {
  if (kind === 'end') return endPlantState(name, reason || null)
  return kind === 'declare' ? declarePlantState(name, reason, minutes) : extendPlantState(name, reason, minutes)
}
