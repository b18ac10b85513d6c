// The dialog in which a user makes a note: an event with a text of one's own.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { makeNote } from '../api/calls.ts'
import { moment } from '../lib/format.ts'
import { t } from '../texts/texts.ts'
import { FormEnd } from './form-dialog.tsx'
import { errorText, useModal } from './hooks.ts'

const LONGEST_NOTE = 500

interface Props {
  /** The time that the note is about; `null` is the present. */
  at: number | null
  /** Called after the station has the note. */
  made: () => void
  close: () => void
}

export function NoteDialog({ at, made, close }: Props): JSX.Element {
  const dialog = useModal()
  const [text, setText] = useState('')
  const [error, setError] = useState<string | null>(null)
  const [isBusy, setBusy] = useState(false)
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault()
    setBusy(true)
    try {
      await makeNote(text, at)
      made()
      close()
    } catch (error) {
      setError(errorText(error))
      setBusy(false)
    }
  }
  return (
    <dialog ref={dialog} onClose={close} aria-label={t.note.make} class="form-dialog">
      <h2>{at === null ? t.note.aboutNow : t.note.about(moment(at))}</h2>
      <form onSubmit={submit}>
        <label>
          {t.note.text}
          <input
            required
            maxLength={LONGEST_NOTE}
            pattern=".*\S.*"
            value={text}
            onInput={(event) => setText(event.currentTarget.value)}
          />
        </label>
        <FormEnd submit={t.note.submit} close={close} error={error} isBusy={isBusy} />
      </form>
    </dialog>
  )
}
