// What stands in place of data: that they are being fetched, that they could not be, or that there are none.

import './query-state.css'
import type { ComponentChildren, JSX } from 'preact'
import { t } from '../texts/texts.ts'
import type { Query } from './hooks.ts'

interface Props {
  /** The data are there when all of these are. The first failure is shown, also above data that are there: they may be old. */
  of: Pick<Query<unknown>, 'value' | 'error' | 'again'>[]
  /** The words while they are being fetched, where more is known than that. */
  loading?: string
  /** The words if the data are there and there is nothing to show. */
  empty?: ComponentChildren
}

export function QueryState({ of, loading = t.log.loading, empty }: Props): JSX.Element | null {
  const failed = of.find(({ error }) => error !== null)
  if (failed) {
    return (
      <p class="error query-state failed" role="status">
        <span>{failed.error}</span>
        <button type="button" onClick={failed.again}>
          {t.log.again}
        </button>
      </p>
    )
  }
  if (of.some(({ value }) => value === null)) {
    return (
      <p class="progress busy query-state loading" role="status">
        {loading}
      </p>
    )
  }
  return empty ? <p class="muted query-state empty">{empty}</p> : null
}
