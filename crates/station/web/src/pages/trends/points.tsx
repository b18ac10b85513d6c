// The points of slaves on the trends page: a chart below the pressures for each unit, and the list from which they are chosen.

import './points.css'
import type { JSX } from 'preact'
import { pointsCsvAddress, pointsParquetAddress } from '../../api/calls.ts'
import { Chart } from '../../components/chart.tsx'
import { type FetchedPoints, rangeAfterKey } from '../../components/use-trends.ts'
import { curveColour } from '../../lib/curves.ts'
import {
  curveOf,
  linearScale,
  type OfferedPoint,
  type PointGroup,
  pointAt,
  pointGroups,
  untilNow,
} from '../../lib/point-trends.ts'
import { pointText } from '../../lib/points.ts'
import { DEFAULT_RANGE, isLive, type Range, SHORTEST_MS, windowOf, zoomed } from '../../lib/range.ts'
import { join, stretches, withoutData } from '../../lib/series.ts'
import { isStale } from '../../lib/stale.ts'
import { useLive } from '../../live.ts'
import { useDark } from '../../settings.ts'
import { t } from '../../texts/texts.ts'
import type { TrendChoice } from './choice.ts'

interface ChartsProps {
  /** All points, which have their colours by their places. */
  all: { key: string }[]
  fetched: FetchedPoints | null
  choice: TrendChoice
  now: number
  /** The number that a slave shows now; `null` without one. */
  presentOf: (key: string) => number | null
  width: number
  setRange: (range: Range) => void
  setCursor: (position: number | null) => void
}

/** The height of a chart. */
const HEIGHT_PX = 190

/** A chart for each unit, below that of the pressures. */
export function PointCharts({ fetched, ...props }: ChartsProps): JSX.Element {
  return (
    <>
      {pointGroups(fetched?.trends ?? []).map((group) => (
        <PointChart group={group} binMs={fetched?.binMs ?? 1} {...props} key={groupKey(group)} />
      ))}
    </>
  )
}

const groupKey = ({ isCode, unit, trends }: PointGroup): string =>
  isCode || unit === '' ? trends.map((trend) => curveOf(trend).series).join() : unit

function PointChart(props: Omit<ChartsProps, 'fetched'> & { group: PointGroup; binMs: number }): JSX.Element {
  const { all, group, binMs, choice, now, presentOf, width, setRange, setCursor } = props
  const dark = useDark()
  const window = windowOf(choice.range, now)
  const curves = group.trends.map((trend) => {
    const curve = curveOf(trend)
    return untilNow(curve, isLive(choice.range) ? presentOf(curve.series) : null, now)
  })
  const { times, curves: drawn } = join(curves, binMs)
  const names = curves.map(({ series }) => series).join(', ')
  const until = isLive(choice.range) ? now : Math.min(now, window[1])
  return (
    <Chart
      label={t.trends.pointChart(names, group.unit)}
      times={times}
      curves={drawn}
      lines={curves.map((curve) => ({
        name: curve.series,
        colour: pointColour(all, curve.series, dark),
        stepped: group.isCode,
        stretches: [...stretches(curve, binMs), ...withoutData(curve, binMs, [window[0], until])],
      }))}
      window={window}
      scale={linearScale(curves, window)}
      log={false}
      isBelow={true}
      unit={group.unit}
      marks={choice.reference === null ? [] : [{ at: choice.reference, name: t.trends.reference }]}
      width={width}
      height={HEIGHT_PX}
      dark={dark}
      onSelect={(from, to) => setRange({ from, to: Math.max(to, from + SHORTEST_MS) })}
      onZoom={(at, factor) => setRange(zoomed(window, at, factor))}
      onCursor={setCursor}
      onKey={(key) => {
        const next = rangeAfterKey(key, choice.range, now, DEFAULT_RANGE)
        if (next) setRange(next)
        return next !== null
      }}
    />
  )
}

export const pointColour = (all: { key: string }[], key: string, dark: boolean): string =>
  curveColour(
    all.findIndex((point) => point.key === key),
    dark,
  )

interface ListProps {
  all: OfferedPoint[]
  chosen: string[]
  fetched: FetchedPoints | null
  /** The time at the cursor; `null` without a cursor. */
  at: number | null
  window: [number, number]
  toggle: (key: string) => void
}

/** The points with their values at the cursor or now; those that are marked have a chart. */
export function PointList({ all, chosen, fetched, at, window, toggle }: ListProps): JSX.Element {
  const { since } = useLive()
  const dark = useDark()
  const shownValue = (offered: OfferedPoint): string => {
    const trend = fetched?.trends.find((trend) => curveOf(trend).series === offered.key)
    const recorded = at === null || !trend ? null : pointAt(trend, at, fetched?.binMs ?? 1)
    const present = pointText(offered.point, isStale(offered.gauge, since))
    return (at === null ? present : recorded) ?? t.common.noData
  }
  return (
    <fieldset class="point-list panel">
      <legend>{t.trends.points}</legend>
      <ul>
        {all.map((offered) => {
          const isDrawn = chosen.includes(offered.key)
          const colour = pointColour(all, offered.key, dark)
          return (
            <li key={offered.key}>
              <label>
                <input
                  type="checkbox"
                  checked={isDrawn}
                  onChange={() => toggle(offered.key)}
                  style={{ accentColor: colour }}
                />
                <span>{offered.key}</span>
                <span class="value">{(at === null || isDrawn) && shownValue(offered)}</span>
              </label>
            </li>
          )
        })}
      </ul>
      <div class="bar">
        <a class="button" href={pointsCsvAddress(...window)} download="points.csv">
          {t.trends.savePointsCsv}
        </a>
        {import.meta.env.VITE_WITHOUT_PARQUET === undefined && (
          <a class="button" href={pointsParquetAddress(...window)} download="points.parquet">
            {t.trends.savePointsParquet}
          </a>
        )}
      </div>
    </fieldset>
  )
}
