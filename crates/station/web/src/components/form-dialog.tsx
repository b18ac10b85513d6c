// The parts that dialogs with a form share: the reason of a user, and the end of the form.

import type { JSX } from 'preact'
import { t } from '../texts/texts.ts'

/** The station accepts no longer reason. */
const LONGEST_REASON = 500

interface ReasonProps {
  reason: string
  setReason: (reason: string) => void
  isOptional?: boolean
}

/** The field for a reason: of more than blanks, unless it is optional. */
export function ReasonField({ reason, setReason, isOptional = false }: ReasonProps): JSX.Element {
  return (
    <label>
      {isOptional ? t.plantStates.reasonOptional : t.common.reason}
      <input
        required={!isOptional}
        maxLength={LONGEST_REASON}
        pattern={isOptional ? undefined : '.*\\S.*'}
        value={reason}
        onInput={(event) => setReason(event.currentTarget.value)}
      />
    </label>
  )
}

interface EndProps {
  /** The word on the button that submits the form. */
  submit: string
  close: () => void
  /** Why the station has refused the form. */
  error?: string | null
  isBusy?: boolean
}

/** The end of a form: the refusal of the station, the button that submits, and the one that closes the dialog. */
export function FormEnd({ submit, close, error = null, isBusy = false }: EndProps): JSX.Element {
  return (
    <>
      {error !== null && (
        <p class="error" role="alert">
          {error}
        </p>
      )}
      <div class="buttons">
        <button type="submit" class="main" disabled={isBusy}>
          {submit}
        </button>
        <button type="button" onClick={close}>
          {t.common.cancel}
        </button>
      </div>
    </>
  )
}
