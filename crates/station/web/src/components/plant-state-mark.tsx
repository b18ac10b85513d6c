// In the header of all pages: the declared plant states.

import './plant-state-mark.css'
import type { JSX } from 'preact'
import type { Snapshot } from '../api/types.ts'
import { declaredNames } from '../lib/plant-states.ts'
import { Link } from '../router.tsx'
import { t } from '../texts/texts.ts'

export function PlantStateMark({ snapshot }: { snapshot: Snapshot }): JSX.Element | null {
  const { plant_states: declared, suppressed } = snapshot.alarms
  if (declared.length === 0) return null
  return (
    <Link to="/alarms" class="plant-state-mark" title={t.plantStates.suppressedCount(suppressed)}>
      <span class="visually-hidden">{t.plantStates.prefix}</span>
      <span aria-hidden="true">▣ </span>
      {declaredNames(declared)}
    </Link>
  )
}
