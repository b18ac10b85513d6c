// The wall display: large values without controls, the problems first.

import './wall.css'
import type { JSX } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'
import type { ActiveAlarms, Gauge, Quality, Reading, Segment } from '../api/types.ts'
import { AlarmSummaryText, PriorityMark } from '../components/alarm-marks.tsx'
import { AlarmSound } from '../components/alarm-sound.tsx'
import { labelsOf, passesNow, UnknownState, useDirectory, useFilter } from '../components/gauge-filter.tsx'
import { OtherAlarms } from '../components/other-alarms.tsx'
import { boundOf, ReadingText } from '../components/pressure.tsx'
import { countsText, summary } from '../lib/alarms.ts'
import { needsLabels } from '../lib/filter.ts'
import { age, clock, day } from '../lib/format.ts'
import { recorderProblem } from '../lib/labels.ts'
import { slaveValue } from '../lib/points.ts'
import { pressureRange } from '../lib/pressure-range.ts'
import { currentQuality, isStale } from '../lib/stale.ts'
import type { Unit } from '../lib/units.ts'
import {
  gridOf,
  isShared,
  pageAt,
  pagesOf,
  type QuietSegment,
  sharedTiles,
  silentText,
  stayingOf,
  type Tile,
  tilesOf,
} from '../lib/wall.ts'
import { type Live, useLive, useSnapshot } from '../live.ts'
import { go } from '../router.tsx'
import { applyTheme, useUnit } from '../settings.ts'
import { t } from '../texts/texts.ts'
import { type GaugeProps, urgency } from './overview.tsx'

interface TileProps extends Tile<Reading> {
  gauge: Gauge
  live: Live
  unit: Unit
}

export function Wall(): JSX.Element {
  const live = useLive()
  const unit = useUnit()
  const { segments, gauges, alarms, station } = useSnapshot()
  const [filter] = useFilter()
  const { directory, error } = useDirectory()
  const [box, width, height] = useSize()
  useDarkTheme()
  useNewVersion(station.version)
  useEscape()
  const isWaiting = directory === null && error === null && needsLabels(filter)
  const shown = gauges
    .map((gauge): GaugeProps => {
      const own = alarms.alarms.filter((alarm) => alarm.gauge === gauge.name)
      return { gauge, labels: labelsOf(directory, gauge.name), alarms: own, live, unit }
    })
    .filter(({ gauge, labels, alarms }) => passesNow(filter, gauge, labels, alarms, live))
  const tiles = shown.flatMap(({ gauge, alarms }) =>
    tilesOf(gauge.readings, alarms, gauge.state === 'fault').map((tile): TileProps => ({ ...tile, gauge, live, unit })),
  )
  const urgencyOf = (tile: TileProps): number => urgency({ gauge: ofTile(tile), alarms: tile.alarms })
  const problems = tiles.filter((tile) => urgencyOf(tile) > 0).sort((one, other) => urgencyOf(other) - urgencyOf(one))
  const quiet = tiles.filter((tile) => urgencyOf(tile) === 0)
  const readings = shown.reduce((sum, { gauge }) => sum + Math.max(1, gauge.readings.length), 0)
  const others = isShared(readings, innerWidth, innerHeight) ? sharedTiles(problems, quiet, names(segments)) : quiet
  const grid = gridOf(problems.length + others.length, width, height)
  const pages = pagesOf<TileProps | QuietSegment<Gauge>>(problems, others, grid.columns * grid.rows)
  const page = pageAt(live.now, pages.length)
  // Problems that are not on every page.
  const turning = problems.slice(
    pages.length > 1 ? stayingOf(problems.length, grid.columns * grid.rows) : problems.length,
  )
  return (
    <div class="wall">
      <h1 class="visually-hidden">{t.wall.title}</h1>
      <p class="wall-head">
        <strong>{station.name}</strong>
        <WallAlarms />
        {pages.length > 1 && <span class="wall-page">{t.wall.page(page + 1, pages.length)}</span>}
        <time>
          <span class="wall-day">{day(live.now)} </span>
          {clock(live.now)}
        </time>
      </p>
      <WallProblem live={live} />
      <OtherAlarms alarms={alarms.alarms} gauges={gauges} />
      {turning.length > 0 && (
        <p class="wall-turning">
          {t.wall.turning(turning.length, turning.slice(0, MOST_NAMES).map(nameOf).join(', '))}
          {turning.length > MOST_NAMES && ' …'}
        </p>
      )}
      <UnknownState />
      {isWaiting && <p>{t.overview.waiting}</p>}
      {!isWaiting && shown.length === 0 && <p>{t.wall.noneFiltered}</p>}
      <div
        class="wall-tiles"
        ref={box}
        style={{ '--columns': String(grid.columns), '--tile': `${grid.width}px`, '--row': `${grid.height}px` }}
        data-pages={pages.length}
      >
        {(pages[page] ?? []).map((shown) =>
          'segment' in shown ? (
            <SegmentTile {...shown} live={live} unit={unit} key={`segment ${shown.segment}`} />
          ) : (
            <WallTile {...shown} key={nameOf(shown)} />
          ),
        )}
      </div>
    </div>
  )
}

/** The line about the problems that turn names this many. */
const MOST_NAMES = 6

/** The gauge as its tile shows it: the fault of a controller is not that of each channel. */
const ofTile = ({ gauge, reading }: TileProps): Gauge =>
  gauge.state === 'fault' && reading && gauge.readings.length > 1 ? { ...gauge, state: 'data-exchange' } : gauge

const names = (segments: readonly Segment[]): string[] => segments.map(({ name }) => name)

const nameOf = ({ gauge, reading }: TileProps): string => reading?.series ?? gauge.name

function WallTile(tile: TileProps): JSX.Element {
  const { reading, alarms, live, unit } = tile
  const gauge = ofTile(tile)
  const stale = isStale(gauge, live.since)
  const [first, ...more] = alarms
  const quality = reading && currentQuality(gauge, reading, live.since)
  const words = gauge.kind === 'slave' ? slaveValue(gauge, stale).point : beyondWords(quality)
  return (
    <article class={`wall-tile ${stale ? 'stale' : ''}`} data-series={reading?.series ?? gauge.name}>
      <h2>{reading?.series ?? gauge.name}</h2>
      <p class="wall-value">
        {reading && quality ? (
          <ReadingText pa={boundOf(reading)} quality={quality} unit={unit} />
        ) : (
          <WholeGauge gauge={gauge} isStale={stale} />
        )}
      </p>
      {first && words && <p class="wall-quality">{words}</p>}
      <p class="wall-state">
        {first && (
          <>
            <PriorityMark priority={first.priority} active={true} /> {first.name}
            {more.length > 0 && t.wall.more(more.length)}
          </>
        )}
        {!first && [words, gauge.state === 'data-exchange' ? '' : stateText(gauge)].filter(Boolean).join(' · ')}
      </p>
    </article>
  )
}

/** The state of a gauge with several channels, in the place of a value. */
function WholeGauge({ gauge, isStale }: { gauge: Gauge; isStale: boolean }): JSX.Element {
  if (gauge.kind === 'slave') return <SlaveValue gauge={gauge} isStale={isStale} />
  if (gauge.readings.length === 0 || isStale) return <span class="no-pressure stale">{t.common.noData}</span>
  if (gauge.state === 'fault') return <ReadingText pa={null} quality="fault" unit="Pa" />
  return <span class="no-pressure">{t.wall.whole}</span>
}

/** The first point of a slave, or its fault. */
function SlaveValue({ gauge, isStale }: { gauge: Gauge; isStale: boolean }): JSX.Element {
  const { text, isFault } = slaveValue(gauge, isStale)
  if (isFault) return <ReadingText pa={null} quality="fault" unit="Pa" />
  return text === null ? <span class="no-pressure stale">{t.common.noData}</span> : <span>{text}</span>
}

/** How many gauges of a segment have no problem, with their lowest and highest pressure. */
function SegmentTile({ segment, gauges, live, unit }: QuietSegment<Gauge> & { live: Live; unit: Unit }): JSX.Element {
  const range = pressureRange(gauges, live.since)
  const isLost = gauges.every((gauge) => isStale(gauge, live.since))
  return (
    <article class={`wall-tile ${isLost ? 'stale' : ''}`} data-segment={segment}>
      <h2>{segment}</h2>
      {range ? (
        <p class="wall-value wall-range">
          <span class="wall-word">{t.wall.lowest}</span> <ReadingText {...range.lowest} unit={unit} />
          <span class="wall-word">{t.wall.highest}</span> <ReadingText {...range.highest} unit={unit} />
        </p>
      ) : (
        <p class="wall-value">
          <span class={`no-pressure ${isLost ? 'stale' : ''}`}>{isLost ? t.common.noData : t.wall.noPressure}</span>
        </p>
      )}
      <p class="wall-state">{t.wall.quiet(gauges.length)}</p>
    </article>
  )
}

/** The word beside `<` or `>`. */
const beyondWords = (quality: Quality | null): string =>
  quality === 'underrange' || quality === 'overrange' ? t.qualities[quality] : ''

const stateText = ({ state, problem }: Gauge): string => problem ?? t.busStatus[state].label

/** The number of alarms, as text, and what silences others. */
function WallAlarms(): JSX.Element {
  const { alarms } = useSnapshot()
  const silent = silentText(alarms)
  return (
    <span>
      <AlarmNumbers alarms={alarms} />
      {silent && <span class="wall-silent"> · {silent}</span>} <AlarmSound />
    </span>
  )
}

function AlarmNumbers({ alarms }: { alarms: ActiveAlarms }): JSX.Element {
  const { connected } = useLive()
  const counts = summary(alarms)
  if (alarms.problem) return <>{t.wall.notMonitored(alarms.problem)}</>
  if (!counts) return <>{t.wall.noAlarms}</>
  if (counts.active.length === 0) return <>{t.wall.noneActive(countsText(counts.unacknowledgedCounts))}</>
  return (
    <>
      <span class="visually-hidden">{t.alarms.badge.prefix}</span>
      {!connected && `${t.alarms.badge.lastKnown} `}
      <AlarmSummaryText summary={counts} />
    </>
  )
}

/** What makes the whole display doubtful. */
function WallProblem({ live }: { live: Live }): JSX.Element | null {
  const { station } = useSnapshot()
  const text = live.connected ? recorderProblem(station.recorder) : t.wall.noConnection(age(live.since))
  return text ? (
    <p class="wall-problem" role="alert">
      {text}
    </p>
  ) : null
}

/** Dark, unless the address says `theme=light`; the theme of the user returns with the other pages. */
function useDarkTheme(): void {
  useEffect(() => {
    const isLight = new URLSearchParams(location.search).get('theme') === 'light'
    document.documentElement.dataset.theme = isLight ? 'light' : 'dark'
    return applyTheme
  }, [])
}

/** After an update of the station the display loads the new dashboard by itself. */
function useNewVersion(version: string): void {
  const first = useRef(version)
  useEffect(() => {
    if (version !== first.current) location.reload()
  }, [version])
}

/** Escape leads to the overview with the same filter. */
function useEscape(): void {
  useEffect(() => {
    const pressed = ({ key }: KeyboardEvent): void => {
      if (key === 'Escape') go(`/${location.search}`)
    }
    addEventListener('keydown', pressed)
    return () => removeEventListener('keydown', pressed)
  }, [])
}

/** The size of an element in pixels. */
function useSize(): [(element: HTMLElement | null) => void, number, number] {
  const [element, setElement] = useState<HTMLElement | null>(null)
  const [size, setSize] = useState({ width: 0, height: 0 })
  useEffect(() => {
    if (!element) return
    const observer = new ResizeObserver(([entry]) => {
      if (entry) setSize({ width: entry.contentRect.width, height: entry.contentRect.height })
    })
    observer.observe(element)
    return () => observer.disconnect()
  }, [element])
  return [setElement, size.width, size.height]
}
