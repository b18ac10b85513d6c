// Pump-downs over each other: one of them beside the last ten or a chosen one, its times to each decade, and its deviation in words.

import './pump-downs.css'
import type { JSX } from 'preact'
import { fetchPumpDowns, reportAddress } from '../../api/calls.ts'
import type { PumpDown } from '../../api/types.ts'
import { Choice, sameText } from '../../components/fields.tsx'
import { useQuery } from '../../components/hooks.ts'
import { LogChart, PressureGrid, TimeGrid } from '../../components/log-chart.tsx'
import { Pressure } from '../../components/pressure.tsx'
import { QueryState } from '../../components/query-state.tsx'
import { Sprays } from '../../components/sprays.tsx'
import { allSeries } from '../../components/use-trends.ts'
import { moment, readable } from '../../lib/format.ts'
import { axesOf, polyline, timeText, usualness, usualText } from '../../lib/pump-downs.ts'
import { live, useSnapshot } from '../../live.ts'
import { Link, setQuery, useLocation } from '../../router.tsx'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'

/** A running pump-down is fetched again this often. */
const REFRESH_MS = 30_000

/** The days that can be chosen; their texts are `t.pumpDowns.days[days]`. */
const DAYS = [7, 30, 90, 730] as const

const DAY_MS = 86_400_000

/** The height of the chart in pixels. */
const HEIGHT = 392

export function PumpDowns(): JSX.Element {
  const { query } = useLocation()
  const names = allSeries(useSnapshot().gauges).map(({ series }) => series)
  const series = query.get('series') ?? names[0] ?? ''
  const unit = useUnit()
  const days = query.get('days') ?? '30'
  const reference = query.get('reference')
  const change = (name: string, value: string): void => {
    const next = new URLSearchParams(query)
    if (value) next.set(name, value)
    else next.delete(name)
    if (name === 'series') ['run', 'reference'].map((key) => next.delete(key))
    setQuery(next)
  }
  const fetched = useQuery(JSON.stringify([series, days, reference]), REFRESH_MS, async (signal) => {
    const to = Math.ceil(live().now)
    return series ? fetchPumpDowns(series, to - Number(days) * DAY_MS, to, reference, signal) : null
  })
  const runs = fetched.value?.series === series ? fetched.value.runs : []
  const shown = runs.find(({ start_ms }) => String(start_ms) === query.get('run')) ?? runs[0]
  const starts = runs.map(({ start_ms }): [string, string] => [String(start_ms), moment(start_ms)])
  return (
    <div class="pump-downs">
      <h1>{t.pumpDowns.title}</h1>
      <div class="bar">
        <Choice
          label={t.pumpDowns.series}
          value={series}
          options={sameText(names.includes(series) ? names : [series, ...names])}
          onChange={(value) => change('series', value)}
        />
        <Choice
          label={t.pumpDowns.timeRange}
          value={days}
          options={DAYS.map((days) => [`${days}`, t.pumpDowns.days[days]] as const)}
          onChange={(value) => change('days', value)}
        />
        <Choice
          label={t.pumpDowns.compareWith}
          value={reference ?? ''}
          options={[
            ['', t.pumpDowns.lastTen],
            ...starts.map(([start, text]) => [start, t.pumpDowns.thatOf(text)] as const),
          ]}
          onChange={(value) => change('reference', value)}
        />
        <Link to={`/rise/identify?series=${encodeURIComponent(series)}`}>{t.identify.link}</Link>
        <Link to={`/trends?series=${encodeURIComponent(series)}`}>{t.pages['/trends']}</Link>
      </div>
      {shown ? (
        <>
          <Verdict run={shown} />
          <Sprays sprays={shown.sprays} />
          <Overlay runs={runs} shown={shown} />
          <Levels run={shown} />
          <p>
            <a href={reportAddress({ series, from: shown.start_ms, to: shown.end_ms, unit })} download>
              {t.pumpDowns.report}
            </a>
          </p>
          <Runs runs={runs} shown={shown} show={(run) => change('run', String(run.start_ms))} />
        </>
      ) : (
        <QueryState of={[fetched]} empty={t.pumpDowns.none} />
      )}
      {shown && <QueryState of={[fetched]} />}
    </div>
  )
}

function Verdict({ run: { deviation, levels } }: { run: PumpDown }): JSX.Element {
  if (deviation) {
    return (
      <p class="verdict deviates" role="status" lang="en">
        <span aria-hidden="true">▲</span> <strong>{readable(deviation.text)}</strong>: {readable(deviation.likeness)}.
      </p>
    )
  }
  const compared = levels.filter(({ usual }) => usual).length
  return (
    <p class="verdict" role="status">
      {compared > 0 ? t.pumpDowns.asUsual : t.pumpDowns.tooFew}
    </p>
  )
}

/** The curves on logarithmic axes, the shown one on top. */
function Overlay({ runs, shown }: { runs: PumpDown[]; shown: PumpDown }): JSX.Element | null {
  const unit = useUnit()
  const axes = axesOf(runs)
  if (!axes) return null
  const others = runs.filter((run) => run !== shown)
  return (
    <figure class="panel">
      <figcaption class="legend">
        <span class="shown">━ {moment(shown.start_ms)}</span>
        {others.some(({ deviation }) => !deviation) && <span>─ {t.pumpDowns.others}</span>}
        {others.some(({ deviation }) => deviation) && <span>╌ {t.pumpDowns.othersDeviating}</span>}
      </figcaption>
      <LogChart height={HEIGHT} label={t.pumpDowns.chart(runs.length, unit)}>
        {(width, height) => (
          <>
            <TimeGrid axes={axes} width={width} height={height} name={t.pumpDowns.seconds} />
            <PressureGrid axes={axes} width={width} height={height} />
            {others.map((run) => (
              <polyline
                key={run.start_ms}
                class={run.deviation ? 'other deviates' : 'other'}
                points={polyline(run, axes, width, height)}
              />
            ))}
            <polyline class="shown" points={polyline(shown, axes, width, height)} />
          </>
        )}
      </LogChart>
    </figure>
  )
}

function Levels({ run }: { run: PumpDown }): JSX.Element {
  const unit = useUnit()
  return (
    <section class="panel" aria-label={t.pumpDowns.times}>
      <table class="stacked">
        <caption>{t.pumpDowns.caption(moment(run.start_ms))}</caption>
        <thead>
          <tr>
            <th scope="col">{t.pumpDowns.pressure}</th>
            <th scope="col">{t.common.time}</th>
            <th scope="col">{t.pumpDowns.usual}</th>
          </tr>
        </thead>
        <tbody>
          {run.levels.map((level) => (
            <tr key={level.pa} class={level.deviation ? 'deviates' : undefined}>
              <th scope="row">
                <Pressure pa={level.pa} unit={unit} />
              </th>
              <td data-title={t.common.time}>
                {timeText(level)}
                {level.deviation && <small>{t.pumpDowns.deviations[level.deviation]}</small>}
              </td>
              <td data-title={t.pumpDowns.usual}>{usualText(level)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </section>
  )
}

interface RunsProps {
  runs: PumpDown[]
  shown: PumpDown
  show: (run: PumpDown) => void
}

function Runs({ runs, shown, show }: RunsProps): JSX.Element {
  return (
    <section class="panel" aria-label={t.pumpDowns.all}>
      <ul class="runs">
        {runs.map((run) => (
          <li key={run.start_ms}>
            <button type="button" aria-pressed={run === shown} onClick={() => show(run)}>
              {moment(run.start_ms)}
            </button>
            {run.deviation ? <span lang="en">{readable(run.deviation.text)}</span> : <span>{usualness(run)}</span>}
          </li>
        ))}
      </ul>
    </section>
  )
}
