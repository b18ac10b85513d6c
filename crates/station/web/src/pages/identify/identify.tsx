// A plant from its record: pump-down, base pressure and rise give effective speed, leak, outgassing and ultimate pressure.

import './identify.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { fetchPumpDowns, identifyPlant, reportAddress } from '../../api/calls.ts'
import type { PlantQuery } from '../../api/types.ts'
import { useQuery } from '../../components/hooks.ts'
import { QueryState } from '../../components/query-state.tsx'
import { allSeries } from '../../components/use-trends.ts'
import { live, useSnapshot } from '../../live.ts'
import { Link, setQuery, useLocation } from '../../router.tsx'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'
import { PlantChart, Residuals } from './chart.tsx'
import { Form } from './form.tsx'
import { choiceIn, queryOf, reported, textOf } from './request.ts'
import { Result } from './result.tsx'

/** Pump-downs of this time can be chosen. */
const PAST_MS = 90 * 86_400_000

/** A running pump-down is listed again this often. */
const REFRESH_MS = 30_000

export function Identify(): JSX.Element {
  const { query } = useLocation()
  const unit = useUnit()
  const names = allSeries(useSnapshot().gauges).map(({ series }) => series)
  const choice = choiceIn(query, names[0] ?? '')
  const [asked, ask] = useState<PlantQuery | null>(null)
  const { series } = choice
  const listed = useQuery(series, REFRESH_MS, async (signal) => {
    const to = Math.ceil(live().now)
    return series ? fetchPumpDowns(series, to - PAST_MS, to, null, signal) : null
  })
  const runs = listed.value?.series === series ? listed.value.runs : []
  const run = runs.find(({ start_ms }) => String(start_ms) === choice.run) ?? runs[0] ?? null
  const wanted = queryOf(choice, run, unit)
  const fitted = useQuery(JSON.stringify(asked), null, async (signal) => asked && identifyPlant(asked, signal))
  const isCurrent = asked !== null && JSON.stringify(asked) === JSON.stringify(wanted.query)
  const plant = isCurrent && fitted.value?.series === series ? fitted.value : null
  return (
    <div class="identify">
      <h1>{t.identify.title}</h1>
      <p class="muted">
        {t.identify.intro} <Link to={`/rise?s=${encodeURIComponent(series)}`}>{t.pages['/rise']}</Link>
      </p>
      <Form
        names={names.includes(series) ? names : [series, ...names]}
        choice={choice}
        runs={runs}
        run={run}
        problem={wanted.problem}
        change={(next) => setQuery(textOf(next))}
        submit={() => ask(wanted.query)}
      />
      <QueryState of={[listed]} />
      <div role="status">
        {isCurrent && fitted.error && <QueryState of={[fitted]} />}
        {isCurrent && !fitted.error && !plant && <p class="waiting">{t.identify.busy}</p>}
        {plant && (
          <>
            <PlantChart plant={plant} />
            <Residuals plant={plant} />
            <Result plant={plant} target={choice.target} />
            {asked?.volume_m3 && (
              <p>
                <a href={reportAddress({ ...reported(asked), unit })} download>
                  {t.pumpDowns.report}
                </a>
              </p>
            )}
          </>
        )}
      </div>
    </div>
  )
}
