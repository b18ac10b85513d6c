// The dialog in which an engineer makes a copy of the database and downloads it.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { backupAddress, makeBackup } from '../api/calls.ts'
import type { Backup } from '../api/types.ts'
import { clock, fileSize, moment } from '../lib/format.ts'
import { t } from '../texts/texts.ts'
import { errorText, useModal } from './hooks.ts'

interface Props {
  /** Called after the station has made a copy. */
  made: () => void
  close: () => void
}

export function BackupDialog({ made, close }: Props): JSX.Element {
  const dialog = useModal()
  const [copy, setCopy] = useState<Backup | null>(null)
  const [isBusy, setBusy] = useState(false)
  const [error, setError] = useState<string | null>(null)
  const make = async (): Promise<void> => {
    setBusy(true)
    setError(null)
    try {
      setCopy(await makeBackup())
      made()
    } catch (error) {
      setError(errorText(error))
    }
    setBusy(false)
  }
  return (
    <dialog ref={dialog} onClose={close} aria-labelledby="backup-title" class="form-dialog">
      <h2 id="backup-title">{t.backup.title}</h2>
      <p>{t.backup.about}</p>
      <p>{t.backup.without}</p>
      <p role="status">
        {isBusy && t.backup.making}
        {copy && t.backup.made(moment(copy.made_ms), fileSize(copy.octets), clock(copy.kept_until_ms))}
      </p>
      {error !== null && (
        <p class="error" role="alert">
          {error}
        </p>
      )}
      <div class="buttons">
        {copy ? (
          <a class="button main" href={backupAddress(copy.id)} download>
            {t.backup.save}
          </a>
        ) : (
          <button type="button" class="main" disabled={isBusy} onClick={() => void make()}>
            {t.backup.make}
          </button>
        )}
        <button type="button" onClick={close}>
          {copy ? t.common.close : t.common.cancel}
        </button>
      </div>
    </dialog>
  )
}
