// The dialog that takes an alarm out of service.

import './out-of-service-dialog.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { takeOutOfService } from '../../api/calls.ts'
import type { Alarm } from '../../api/types.ts'
import { useModal } from '../../components/hooks.ts'
import type { RunAction } from './item.tsx'

const LONGEST_REASON = 500

/** Durations and their minutes. */
const DURATIONS: [label: string, minutes: number | null][] = [
  ['1 hour', 60],
  ['8 hours', 480],
  ['1 day', 1_440],
  ['1 week', 10_080],
  ['until returned to service', null],
]

export function OutOfServiceDialog({
  alarm,
  run,
  close,
}: {
  alarm: Alarm
  run: RunAction
  close: () => void
}): JSX.Element {
  const dialog = useModal()
  const [reason, setReason] = useState('')
  const [duration, setDuration] = useState(0)
  const submit = (event: Event): void => {
    event.preventDefault()
    run(() => takeOutOfService(alarm.name, reason, DURATIONS[duration]?.[1] ?? null))
    close()
  }
  return (
    <dialog ref={dialog} onClose={close} aria-label="Out of service" class="out-of-service-dialog">
      <h2>Take {alarm.name} out of service</h2>
      <p class="muted">
        The alarm is silent until it is returned to service. If its condition holds then, it is raised at once.
      </p>
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
            {DURATIONS.map(([label], index) => (
              <option value={index} key={label}>
                {label}
              </option>
            ))}
          </select>
        </label>
        <div class="buttons">
          <button type="submit" class="main">
            Take out of service
          </button>
          <button type="button" onClick={close}>
            Cancel
          </button>
        </div>
      </form>
    </dialog>
  )
}
