// In the header of all pages: the parts of the station that cannot run, for example a gateway whose address is taken, and an archive that
// does not answer or store.

import './stopped-mark.css'
import type { JSX } from 'preact'
import type { Snapshot } from '../api/types.ts'
import { gatewayTitle } from '../lib/gateways.ts'
import { Link } from '../router.tsx'
import { t } from '../texts/texts.ts'

export function StoppedMark({ snapshot }: { snapshot: Snapshot }): JSX.Element | null {
  const { stopped_parts: parts, archive_problem: archive } = snapshot.station
  if (parts.length === 0 && archive === null) return null
  const names = parts.map(({ name }) => gatewayTitle(name)).join(', ')
  const marks = [parts.length > 0 && t.gateways.stopped(names), archive !== null && t.gateways.notArchived]
  const problems = [...parts.map(({ problem }) => problem), ...(archive === null ? [] : [archive])]
  return (
    <Link to="/gateways" class="stopped-mark" title={problems.join('\n')}>
      {marks.filter(Boolean).join('; ')}
    </Link>
  )
}
