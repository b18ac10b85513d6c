// The dialog that shelves alarms, or takes one out of service.

import './suppress-dialog.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { shelve, takeOutOfService } from '../../api/calls.ts'
import type { Alarm } from '../../api/types.ts'
import { FormEnd, ReasonField } from '../../components/form-dialog.tsx'
import { useModal } from '../../components/hooks.ts'
import { t } from '../../texts/texts.ts'
import { type RunAction, refusals } from './item.tsx'

/** What the dialog does to which alarms. */
export interface Suppress {
  kind: 'shelve' | 'out-of-service'
  alarms: Alarm[]
}

interface Words {
  label: string
  verb: string
  /** The heading, with the name of an alarm or their number. */
  title: (what: string) => string
  /** Durations and their minutes. */
  durations: [label: string, minutes: number | null][]
}

const words = (): Record<Suppress['kind'], Words> => ({
  shelve: {
    label: t.suppress.shelve,
    verb: t.suppress.shelve,
    title: t.suppress.shelveTitle,
    durations: [
      [t.suppress.minutes(30), 30],
      [t.suppress.hours(1), 60],
      [t.suppress.hours(4), 240],
      [t.suppress.hours(8), 480],
      [t.suppress.hours(12), 720],
    ],
  },
  'out-of-service': {
    label: t.suppress.outOfService,
    verb: t.suppress.takeOut,
    title: t.suppress.takeOutTitle,
    durations: [
      [t.suppress.hours(1), 60],
      [t.suppress.hours(8), 480],
      [t.suppress.days(1), 1_440],
      [t.suppress.weeks(1), 10_080],
      [t.alarms.untilReturned, null],
    ],
  },
})

interface Props {
  suppress: Suppress
  run: RunAction
  close: () => void
}

export function SuppressDialog({ suppress: { kind, alarms }, run, close }: Props): JSX.Element {
  const dialog = useModal()
  const [reason, setReason] = useState('')
  const [duration, setDuration] = useState(0)
  const { label, verb, title, durations } = words()[kind]
  const names = alarms.map(({ name }) => name)
  const what = names.length === 1 ? (names[0] ?? '') : t.suppress.alarms(names.length)
  const submit = (event: Event): void => {
    event.preventDefault()
    const minutes = durations[duration]?.[1] ?? null
    run(() => (kind === 'shelve' ? shelveAll(names, reason, minutes) : takeOut(names, reason, minutes)))
    close()
  }
  return (
    <dialog ref={dialog} onClose={close} aria-label={label} class="form-dialog suppress-dialog">
      <h2>{title(what)}</h2>
      <p class="muted">{t.suppress.silent(names.length)}</p>
      {names.length > 1 && <p class="names">{names.join(', ')}</p>}
      <form onSubmit={submit}>
        <ReasonField reason={reason} setReason={setReason} />
        <label>
          {t.suppress.duration}
          <select value={duration} onChange={(event) => setDuration(Number(event.currentTarget.value))}>
            {durations.map(([label], index) => (
              <option value={index} key={label}>
                {label}
              </option>
            ))}
          </select>
        </label>
        <FormEnd submit={verb} close={close} />
      </form>
    </dialog>
  )
}

const shelveAll = (names: string[], reason: string, minutes: number | null): Promise<void> =>
  shelve(names, reason, minutes ?? 0).then(refusals)

async function takeOut(names: string[], reason: string, minutes: number | null): Promise<void> {
  for (const name of names) await takeOutOfService(name, reason, minutes)
}
