// Trends: the pressures of several series over time, on a logarithmic scale; below them points of slaves, each unit on an axis of its own.

import './trends.css'
import type { JSX } from 'preact'
import { useRef, useState } from 'preact/hooks'
import { csvAddress, fetchAlarms, parquetAddress } from '../../api/calls.ts'
import type { Alarm, StationEvent } from '../../api/types.ts'
import { ChartTable } from '../../components/chart-table.tsx'
import { useDirectory } from '../../components/gauge-filter.tsx'
import { type Query, useQuery, useWidth } from '../../components/hooks.ts'
import { SampleText } from '../../components/pressure.tsx'
import { QueryState } from '../../components/query-state.tsx'
import { SeriesList } from '../../components/series-list.tsx'
import {
  allSeries,
  hasNoValues,
  seriesAt,
  stationPointTrend,
  useChartData,
  usePointTrends,
  useTrends,
} from '../../components/use-trends.ts'
import { Views } from '../../components/views.tsx'
import { limitsOf } from '../../lib/alarms.ts'
import { curveColours } from '../../lib/curves.ts'
import { type Difference, differenceOf, differenceText } from '../../lib/difference.ts'
import { day, moment } from '../../lib/format.ts'
import { offeredPoints } from '../../lib/point-trends.ts'
import { isLive, type Range, windowOf } from '../../lib/range.ts'
import { isStale } from '../../lib/stale.ts'
import { useLive, useSnapshot } from '../../live.ts'
import { Link } from '../../router.tsx'
import { useDark, useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'
import { TrendChart, trendPixels } from './chart.tsx'
import { useTrendChoice } from './choice.ts'
import { EventLane } from './event-lane.tsx'
import { AlarmLimits } from './limits.tsx'
import { type PictureText, savePng } from './png.ts'
import { PointCharts, PointList } from './points.tsx'
import { Reference, useReferenceSamples } from './reference.tsx'
import { CustomWindow, Toolbar } from './toolbar.tsx'

/** Alarms are fetched this often; their limits change only with the station's file. */
const LIMITS_MS = 10_000

export function Trends(): JSX.Element {
  const { now, since } = useLive()
  const unit = useUnit()
  const { gauges, station } = useSnapshot()
  const all = allSeries(gauges)
  const names = all.map(({ series }) => series)
  const points = offeredPoints(gauges)
  const [choice, change] = useTrendChoice(
    names,
    points.map(({ key }) => key),
  )
  const { series: chosen, points: chosenPoints, range, reference } = choice
  const [box, width] = useWidth()
  const panel = useRef<HTMLDivElement>(null)
  /** The position of the cursor, 0 to 1. */
  const [cursor, setCursor] = useState<number | null>(null)
  const [notes, setNotes] = useState(0)
  const query = useTrends(chosen, range, trendPixels(width), notes)
  const data = useChartData(query.value, range, unit, now)
  const drawnPoints = points.filter(({ key }) => chosenPoints.includes(key))
  const pointQuery = usePointTrends(drawnPoints, range, trendPixels(width), stationPointTrend)
  const fetchedPoints = drawnPoints.length === 0 ? null : pointQuery.value
  const presentOf = (key: string): number | null => {
    const offered = points.find((one) => one.key === key)
    return offered?.point.quality === 'valid' && !isStale(offered.gauge, since) ? offered.point.number : null
  }
  const events = query.value?.events ?? []
  const window = windowOf(range, now)
  const whole: [number, number] = [Math.floor(window[0]), Math.ceil(window[1])]
  const at = cursor === null ? null : window[0] + cursor * (window[1] - window[0])
  const colours = curveColours(names, chosen, useDark())
  const colourOf = (series: string): string => colours.get(series) ?? 'gray'
  const alarms = useAlarms()
  const limits = limitsOf(alarms.value ?? [], chosen)
  const setRange = (range: Range): void => change({ range })
  const setReference = (at: number | null): void =>
    change({ reference: at === null ? null : Math.round(Math.min(at, now)) })
  const toggle = (series: string): void =>
    change({ series: names.filter((name) => chosen.includes(name) !== (name === series)) })
  const togglePoint = (key: string): void =>
    change({ points: points.map((one) => one.key).filter((one) => chosenPoints.includes(one) !== (one === key)) })
  const referenceSample = useReferenceSamples(chosen, reference)
  // Without a cursor the list has the present values, which a fixed window need not contain.
  const comparedAt = at ?? (isLive(range) ? now : null)
  const differenceAt = (series: string): Difference | null =>
    reference === null || comparedAt === null
      ? null
      : differenceOf(referenceSample(series), seriesAt(data, series, comparedAt), comparedAt - reference)
  const picture = (): PictureText => ({
    title: `${station.name}, ${t.common.rangeText(moment(window[0]), moment(window[1]))}`,
    curves: chosen.map((name) => {
      const difference = differenceAt(name)
      return { name, colour: colourOf(name), text: difference ? differenceText(difference, unit) : '' }
    }),
    notes: reference !== null && comparedAt !== null ? [t.trends.beside(moment(comparedAt), moment(reference))] : [],
  })
  return (
    <div class="trends">
      <h1 class="visually-hidden">{t.pages['/trends']}</h1>
      <Toolbar choice={choice} change={change} />
      <div class="bar">
        <Views page="/trends" directory={useDirectory().directory} />
      </div>
      <div class="trend-chart panel" ref={panel}>
        <div ref={box}>
          <TrendChart
            all={all}
            choice={choice}
            data={data}
            limits={limits}
            width={width}
            colourOf={colourOf}
            setRange={setRange}
            setCursor={setCursor}
            setReference={(pressed) => setReference(pressed ?? at ?? (window[0] + window[1]) / 2)}
          />
          <EventLane events={events} window={window} width={width} />
        </div>
      </div>
      {fetchedPoints !== null && (
        <div class="trend-chart panel">
          <PointCharts
            all={points}
            fetched={fetchedPoints}
            choice={choice}
            now={now}
            presentOf={presentOf}
            width={width}
            setRange={setRange}
            setCursor={setCursor}
          />
        </div>
      )}
      <Reference reference={reference} at={comparedAt} set={setReference} noted={() => setNotes(notes + 1)} />
      <SeriesList
        all={all}
        chosen={chosen}
        colourOf={colourOf}
        toggle={toggle}
        unit={unit}
        at={at}
        sampleOf={(series, at) => seriesAt(data, series, at)}
        events={eventsNear(events, at, window, width)}
        differenceOf={differenceAt}
      />
      {points.length > 0 && (
        <PointList
          all={points}
          chosen={chosenPoints}
          fetched={fetchedPoints}
          at={at}
          window={whole}
          toggle={togglePoint}
        />
      )}
      <AlarmLimits limits={limits} unit={unit} />
      <QueryState
        of={[query, alarms, ...(points.length > 0 ? [pointQuery] : [])]}
        empty={chosen.length > 0 && hasNoValues(data) && t.log.noValues}
      />
      <div class="bar">
        <CustomWindow window={window} live={isLive(range)} setRange={setRange} />
        <a class="button" href={csvAddress(chosen, ...whole)} download="pressures.csv">
          {t.common.saveCsv}
        </a>
        {import.meta.env.VITE_WITHOUT_PARQUET === undefined && (
          <a class="button" href={parquetAddress(chosen, ...whole)} download="pressures.parquet">
            {t.trends.saveParquet}
          </a>
        )}
        <button
          type="button"
          disabled={chosen.length === 0}
          onClick={() => savePng(panel.current, `pressures ${day(window[1])}.png`, picture())}
        >
          {t.trends.savePng}
        </button>
        <Link to={`/trends/pump-downs${chosen[0] ? `?series=${encodeURIComponent(chosen[0])}` : ''}`}>
          {t.trends.compare}
        </Link>
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

function useAlarms(): Query<Alarm[]> {
  return useQuery('limits', LIMITS_MS, (signal) => fetchAlarms(signal))
}

/** The width around the cursor in which events are listed, to each side. */
const NEAR_PX = 6

function eventsNear(
  events: StationEvent[],
  at: number | null,
  window: [number, number],
  width: number,
): StationEvent[] {
  const reach = (NEAR_PX * (window[1] - window[0])) / Math.max(1, width)
  return at === null ? [] : events.filter(({ at_ms }) => Math.abs(at_ms - at) < reach)
}
