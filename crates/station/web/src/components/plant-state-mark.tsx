// In the header of all pages: the declared plant states.

import './plant-state-mark.css'
import type { JSX } from 'preact'
import type { Snapshot } from '../api/types.ts'
import { declaredNames } from '../lib/plant-states.ts'
import { Link } from '../router.tsx'

export function PlantStateMark({ snapshot }: { snapshot: Snapshot }): JSX.Element | null {
  const { plant_states: declared, suppressed } = snapshot.alarms
  if (declared.length === 0) return null
  const text = `Suppressed alarms: ${suppressed}`
  return (
    <Link to="/alarms" class="plant-state-mark" title={text}>
      <span class="visually-hidden">Plant state: </span>
      <span aria-hidden="true">▣ </span>
      {declaredNames(declared)}
    </Link>
  )
}
