// Trends of series of several stations; below them points of slaves, each unit on an axis of its own.

import '../components/series-list.css'
import '../pages/trends/trends.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { getFrom } from '../api/request.ts'
import type { Trend } from '../api/types.ts'
import { ChartTable } from '../components/chart-table.tsx'
import { SearchField } from '../components/fields.tsx'
import { useWidth } from '../components/hooks.ts'
import { SampleText } from '../components/pressure.tsx'
import { QueryState } from '../components/query-state.tsx'
import { hasNoValues, seriesAt, useChartData, usePointTrends, useTrends } from '../components/use-trends.ts'
import { curveColours } from '../lib/curves.ts'
import { moment } from '../lib/format.ts'
import { curveOf, pointAt } from '../lib/point-trends.ts'
import { isLive, type Range, windowOf } from '../lib/range.ts'
import { matchesWords } from '../lib/search.ts'
import { TrendChart, trendPixels } from '../pages/trends/chart.tsx'
import { useTrendChoice } from '../pages/trends/choice.ts'
import { PointCharts, pointColour } from '../pages/trends/points.tsx'
import { CustomWindow, Toolbar } from '../pages/trends/toolbar.tsx'
import { useDark, useUnit } from '../settings.ts'
import { t } from '../texts/texts.ts'
import { useArchive, useLive } from './live.ts'
import { seriesOf } from './plant.ts'
import { archivedPointTrend, useStationPoints } from './points.ts'

/** The most series in the list beside those that are drawn: the search finds the others. */
const MOST_LISTED = 24

/** The address of the trends of these series. */
export function trendPath(series: string[]): string {
  return `/trends?${new URLSearchParams(series.map((name) => ['s', name]))}`
}

/** The most entries of a trend that a station sends. */
const MOST_FULL = 4_000

/** The trend of a series from the database of its station, which has all samples. */
function fullTrend(series: string, from: number, to: number, pixels: number, signal: AbortSignal): Promise<Trend> {
  const query = { series, from: `${from}`, to: `${to}`, pixels: `${Math.min(pixels, MOST_FULL)}`, full: 'true' }
  return getFrom(`/api/trend?${new URLSearchParams(query)}`, signal)
}

export function Trends(): JSX.Element {
  const { now } = useLive()
  const unit = useUnit()
  const names = seriesOf(useArchive())
  const points = useStationPoints().value ?? []
  const keys = points.map(({ key }) => key)
  const [choice, change] = useTrendChoice(names, keys)
  const { series: chosen, points: chosenPoints, range } = choice
  const [box, width] = useWidth()
  const [cursor, setCursor] = useState<number | null>(null)
  const [isFull, setFull] = useState(false)
  const query = useTrends(chosen, range, trendPixels(width), isFull ? 'full' : '', isFull ? fullTrend : undefined)
  const data = useChartData(query.value, range, unit, now)
  const drawnPoints = points.filter(({ key }) => chosenPoints.includes(key))
  const pointQuery = usePointTrends(drawnPoints, range, trendPixels(width), archivedPointTrend)
  const fetchedPoints = drawnPoints.length === 0 ? null : pointQuery.value
  const window = windowOf(range, now)
  const at = cursor === null ? null : window[0] + cursor * (window[1] - window[0])
  const dark = useDark()
  const colours = curveColours(names, chosen, dark)
  const colourOf = (series: string): string => colours.get(series) ?? 'gray'
  const setRange = (range: Range): void => change({ range })
  const toggle = (series: string): void =>
    change({ series: names.filter((name) => chosen.includes(name) !== (name === series)) })
  const togglePoint = (key: string): void =>
    change({ points: keys.filter((one) => chosenPoints.includes(one) !== (one === key)) })
  const recordedAt = (key: string, at: number): string => {
    const trend = fetchedPoints?.trends.find((trend) => curveOf(trend).series === key)
    return (trend && pointAt(trend, at, fetchedPoints?.binMs ?? 1)) ?? t.common.noData
  }
  return (
    <div class="trends">
      <h1 class="visually-hidden">{t.pages['/trends']}</h1>
      <Toolbar choice={choice} change={change} />
      <div class="trend-chart panel">
        <div ref={box}>
          <TrendChart
            all={[]}
            choice={choice}
            data={data}
            limits={[]}
            width={width}
            colourOf={colourOf}
            setRange={setRange}
            setCursor={setCursor}
            setReference={() => {}}
          />
        </div>
      </div>
      {fetchedPoints !== null && (
        <div class="trend-chart panel">
          <PointCharts
            all={points}
            fetched={fetchedPoints}
            choice={choice}
            now={now}
            presentOf={() => null}
            width={width}
            setRange={setRange}
            setCursor={setCursor}
          />
        </div>
      )}
      <SeriesChoice names={names} chosen={chosen} colourOf={colourOf} toggle={toggle}>
        {(series) => at !== null && <SampleText sample={seriesAt(data, series, at)} unit={unit} />}
      </SeriesChoice>
      {points.length > 0 && (
        <SeriesChoice
          legend={t.trends.points}
          names={keys}
          chosen={chosenPoints}
          colourOf={(key) => pointColour(points, key, dark)}
          toggle={togglePoint}
        >
          {(key) => at !== null && <span>{recordedAt(key, at)}</span>}
        </SeriesChoice>
      )}
      <p class="muted">{at === null ? t.archive.point : moment(at)}</p>
      <QueryState
        of={[query, ...(points.length > 0 ? [pointQuery] : [])]}
        empty={hasNoValues(data) && t.log.noValues}
      />
      <div class="bar">
        <CustomWindow window={window} live={isLive(range)} setRange={setRange} />
        <button type="button" aria-pressed={isFull} onClick={() => setFull(!isFull)} title={t.archive.fullTitle}>
          {t.archive.full}
        </button>
      </div>
      <ChartTable
        caption={t.trends.pressures}
        window={window}
        columns={chosen.map((series) => ({
          name: series,
          cell: (at) => <SampleText sample={seriesAt(data, series, at)} unit={unit} />,
        }))}
      />
    </div>
  )
}

interface ChoiceProps {
  /** The heading of a list of points. */
  legend?: string
  names: string[]
  chosen: string[]
  colourOf: (series: string) => string
  toggle: (series: string) => void
  /** The value of a series that is drawn. */
  children: (series: string) => JSX.Element | false
}

/** Which series or points are drawn. */
function SeriesChoice({ legend, names, chosen, colourOf, toggle, children }: ChoiceProps): JSX.Element {
  const [text, setText] = useState('')
  const others = names.filter((name) => !chosen.includes(name) && matchesWords([name], text))
  const listed = [...names.filter((name) => chosen.includes(name)), ...others.slice(0, MOST_LISTED)]
  const Box = legend === undefined ? 'div' : 'fieldset'
  return (
    <Box class="series-list panel">
      {legend !== undefined && <legend>{legend}</legend>}
      {names.length > MOST_LISTED && <SearchField label={t.trends.search} value={text} onInput={setText} />}
      <ul>
        {listed.map((series) => {
          const drawn = chosen.includes(series)
          const colour = colourOf(series)
          return (
            <li class={drawn ? '' : 'off'} key={series}>
              <label>
                <input
                  type="checkbox"
                  checked={drawn}
                  onChange={() => toggle(series)}
                  style={{ accentColor: colour }}
                />
                <span
                  class="swatch"
                  style={drawn ? { background: colour, borderColor: colour } : {}}
                  aria-hidden="true"
                />
                <span class="name">{series}</span>
                <span class="value">{drawn && children(series)}</span>
              </label>
            </li>
          )
        })}
      </ul>
      {others.length > MOST_LISTED && <p class="muted">{t.trends.moreSeries(others.length - MOST_LISTED)}</p>}
    </Box>
  )
}
