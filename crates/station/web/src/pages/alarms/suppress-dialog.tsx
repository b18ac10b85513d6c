// The dialog that shelves alarms, or takes one out of service.

import './suppress-dialog.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { shelve, takeOutOfService } from '../../api/calls.ts'
import type { Alarm } from '../../api/types.ts'
import { useModal } from '../../components/hooks.ts'
import { type RunAction, refusals } from './item.tsx'

const LONGEST_REASON = 500

/** What the dialog does to which alarms. */
export interface Suppress {
  kind: 'shelve' | 'out-of-service'
  alarms: Alarm[]
}

interface Words {
  label: string
  verb: string
  /** Durations and their minutes. */
  durations: [label: string, minutes: number | null][]
}

const WORDS: Record<Suppress['kind'], Words> = {
  shelve: {
    label: 'Shelve',
    verb: 'Shelve',
    durations: [
      ['30 minutes', 30],
      ['1 hour', 60],
      ['4 hours', 240],
      ['8 hours', 480],
      ['12 hours', 720],
    ],
  },
  'out-of-service': {
    label: 'Out of service',
    verb: 'Take out of service',
    durations: [
      ['1 hour', 60],
      ['8 hours', 480],
      ['1 day', 1_440],
      ['1 week', 10_080],
      ['until returned to service', null],
    ],
  },
}

interface Props {
  suppress: Suppress
  run: RunAction
  close: () => void
}

export function SuppressDialog({ suppress: { kind, alarms }, run, close }: Props): JSX.Element {
  const dialog = useModal()
  const [reason, setReason] = useState('')
  const [duration, setDuration] = useState(0)
  const { label, verb, durations } = WORDS[kind]
  const names = alarms.map(({ name }) => name)
  const title = names.length === 1 ? (names[0] ?? '') : `${names.length} alarms`
  const submit = (event: Event): void => {
    event.preventDefault()
    const minutes = durations[duration]?.[1] ?? null
    run(() => (kind === 'shelve' ? shelveAll(names, reason, minutes) : takeOut(names, reason, minutes)))
    close()
  }
  return (
    <dialog ref={dialog} onClose={close} aria-label={label} class="form-dialog suppress-dialog">
      <h2>
        {kind === 'shelve' ? 'Shelve' : 'Take out of service'}: {title}
      </h2>
      <p class="muted">
        {names.length === 1 ? 'The alarm is' : 'The alarms are'} silent until then. An alarm whose condition holds at
        the end is raised at once.
      </p>
      {names.length > 1 && <p class="names">{names.join(', ')}</p>}
      <form onSubmit={submit}>
        <label>
          Reason
          <input
            required
            maxLength={LONGEST_REASON}
            pattern=".*\S.*"
            value={reason}
            onInput={(event) => setReason(event.currentTarget.value)}
          />
        </label>
        <label>
          Duration
          <select value={duration} onChange={(event) => setDuration(Number(event.currentTarget.value))}>
            {durations.map(([label], index) => (
              <option value={index} key={label}>
                {label}
              </option>
            ))}
          </select>
        </label>
        <div class="buttons">
          <button type="submit" class="main">
            {verb}
          </button>
          <button type="button" onClick={close}>
            Cancel
          </button>
        </div>
      </form>
    </dialog>
  )
}

const shelveAll = (names: string[], reason: string, minutes: number | null): Promise<void> =>
  shelve(names, reason, minutes ?? 0).then(refusals)

async function takeOut(names: string[], reason: string, minutes: number | null): Promise<void> {
  for (const name of names) await takeOutOfService(name, reason, minutes)
}
