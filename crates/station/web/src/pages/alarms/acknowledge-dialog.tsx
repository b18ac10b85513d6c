// The dialog that asks before many alarms are acknowledged together: it names those that the user may not have seen.

import type { JSX } from 'preact'
import { acknowledgeAll } from '../../api/calls.ts'
import type { Alarm } from '../../api/types.ts'
import { PriorityMark } from '../../components/alarm-marks.tsx'
import { FormEnd } from '../../components/form-dialog.tsx'
import { useModal } from '../../components/hooks.ts'
import { Unbroken } from '../../components/unbroken.tsx'
import { isActive } from '../../lib/alarms.ts'
import { t } from '../../texts/texts.ts'
import { type RunAction, refusals } from './item.tsx'

/** Acknowledges these occurrences of the alarms: one that was raised again meanwhile is refused. */
export const acknowledgeThese = (alarms: Alarm[]): Promise<void> =>
  acknowledgeAll(alarms.map(({ name, occurrence }) => ({ name, occurrence }))).then(refusals)

interface Props {
  alarms: Alarm[]
  run: RunAction
  close: () => void
}

export function AcknowledgeDialog({ alarms, run, close }: Props): JSX.Element {
  const dialog = useModal()
  const title = t.alarms.acknowledgeAll(alarms.length)
  const submit = (event: Event): void => {
    event.preventDefault()
    run(() => acknowledgeThese(alarms))
    close()
  }
  return (
    <dialog ref={dialog} onClose={close} aria-label={title} class="form-dialog acknowledge-dialog">
      <h2>{title}</h2>
      <p class="muted">{t.alarms.acknowledgeThese}</p>
      {/* biome-ignore lint/a11y/noNoninteractiveTabindex: a list that scrolls, before the button: it has the focus first, and the keyboard scrolls it */}
      <section class="names" tabIndex={0} aria-label={t.suppress.alarms(alarms.length)}>
        <ul>
          {alarms.map(({ name, priority, state }) => (
            <li key={name}>
              <PriorityMark priority={priority} active={isActive({ state })} /> <Unbroken text={name} />
            </li>
          ))}
        </ul>
      </section>
      <form onSubmit={submit}>
        <FormEnd submit={title} close={close} />
      </form>
    </dialog>
  )
}
