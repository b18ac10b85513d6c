// The time with which the values of the list are compared.

import './reference.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { fetchTrend } from '../../api/calls.ts'
import type { Trend } from '../../api/types.ts'
import { useQuery } from '../../components/hooks.ts'
import { NoteDialog } from '../../components/note-dialog.tsx'
import { age, moment } from '../../lib/format.ts'
import { BEFORE_MS, type Sample, sampleAt } from '../../lib/series.ts'
import { hasRole, useSession } from '../../session.ts'
import { t } from '../../texts/texts.ts'

interface Props {
  reference: number | null
  /** The time of the values that are compared; `null` if there are none. */
  at: number | null
  set: (at: number | null) => void
  /** Called after a note about the reference was made. */
  noted: () => void
}

export function Reference({ reference, at, set, noted }: Props): JSX.Element {
  const [isNoting, setNoting] = useState(false)
  const mayNote = hasRole(useSession(), 'operator')
  if (reference === null) {
    return <p class="reference muted">{t.trends.noReference}</p>
  }
  return (
    <div class="reference">
      <strong>{t.trends.referenceAt(moment(reference))}</strong>
      <span class="muted">{at === null ? '' : distance(at - reference)}</span>
      <button type="button" onClick={() => set(null)}>
        {t.trends.removeReference}
      </button>
      {mayNote && (
        <button type="button" onClick={() => setNoting(true)}>
          {t.note.make}
        </button>
      )}
      {isNoting && <NoteDialog at={reference} made={noted} close={() => setNoting(false)} />}
    </div>
  )
}

const distance = (ms: number): string => (ms < 0 ? t.trends.before(age(-ms)) : t.trends.after(age(ms)))

/** The samples that held at the reference, also when it is outside the window. */
export function useReferenceSamples(names: string[], reference: number | null): (series: string) => Sample | null {
  const key = `reference ${JSON.stringify([names, reference])}`
  const query = useQuery<Trend[]>(key, null, async (signal) => {
    if (reference === null) return []
    const from = reference - BEFORE_MS
    return Promise.all(names.map((name) => fetchTrend(name, from, reference + BIN_MS, BEFORE_MS / BIN_MS + 1, signal)))
  })
  return (series) => {
    const trend = query.value?.find((trend) => trend.series === series)
    return trend && reference !== null ? sampleAt(trend, reference, BIN_MS) : null
  }
}

/** The samples before a reference are fetched second by second. */
const BIN_MS = 1_000
