// In the header of all pages: the parts of the station that cannot run, for example a gateway whose address is taken.

import './stopped-mark.css'
import type { JSX } from 'preact'
import type { Snapshot } from '../api/types.ts'
import { gatewayTitle } from '../lib/gateways.ts'
import { Link } from '../router.tsx'
import { t } from '../texts/texts.ts'

export function StoppedMark({ snapshot }: { snapshot: Snapshot }): JSX.Element | null {
  const parts = snapshot.station.stopped_parts
  if (parts.length === 0) return null
  const names = parts.map(({ name }) => gatewayTitle(name)).join(', ')
  return (
    <Link to="/gateways" class="stopped-mark" title={parts.map(({ problem }) => problem).join('\n')}>
      {t.gateways.stopped(names)}
    </Link>
  )
}
