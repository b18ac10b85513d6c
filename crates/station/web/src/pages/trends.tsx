// Pressures over time: thirteen decades, several gauges, one cursor.

import type { JSX } from 'preact'
import { useEffect, useState } from 'preact/hooks'
import { alarms, exportAddress, type Alarm, type Gauge, type Priority } from '../api.ts'
import { useLive } from '../live.ts'
import { PriorityMark } from '../parts/alarm.tsx'
import { Chart, timePixels } from '../parts/chart.tsx'
import { colours, own } from '../parts/colours.ts'
import { allSeries, Busy, extent, keyed, readAt, useDrawn, useTrends, type Drawn } from '../parts/trend.tsx'
import { useAsked, useWidth } from '../parts/use.ts'
import { limitsOf, quantity } from '../pure/alarms.ts'
import { inputMoment, moment } from '../pure/format.ts'
import { isLive, moved, rangeOf, rangeText, SPANS, windowOf, zoomed, type Range } from '../pure/range.ts'
import { decades } from '../pure/series.ts'
import { inUnit, UNITS, type Unit } from '../pure/units.ts'
import { ask, usePlace } from '../router.tsx'
import { useDark, useUnit } from '../settings.ts'
import { Readout } from '../parts/readout.tsx'

/** So many are shown before anything is chosen. */
const FIRST = 4

/** All thirteen decades and a little: what gauges of every kind measure together, in Pa. */
const WHOLE: [number, number] = [1e-8, 2e5]

/** Alarms are asked for anew so often: their limits change with the file alone. */
const LIMITS_MS = 10_000

/** The colours of the page that priorities have everywhere. */
const PAINTS: Record<Priority, string> = { high: 'bad', medium: 'warn', low: 'accent' }

const HOME: Range = { last: SPANS[1]!.ms }

/** What the address of the page says, and how it is changed. */
function useChoice(names: string[]): {
  chosen: string[]
  range: Range
  whole: boolean
  choose: (chosen: string[], range: Range, whole: boolean) => void
} {
  const { query } = usePlace()
  const named = query.getAll('s').filter((name) => names.includes(name))
  const chosen = query.has('s') || query.has('none') ? named : names.slice(0, FIRST)
  const choose = (chosen: string[], range: Range, whole: boolean): void => {
    const next = new URLSearchParams(rangeText(range))
    chosen.forEach((name) => next.append('s', name))
    if (chosen.length === 0) next.set('none', '')
    if (whole) next.set('whole', '')
    ask(next)
  }
  return { chosen, range: rangeOf(query), whole: query.has('whole'), choose }
}

export function Trends(): JSX.Element {
  const live = useLive()
  const unit = useUnit()
  const dark = useDark()
  const all = allSeries(live.moment!.gauges)
  const names = all.map(({ series }) => series)
  const { chosen, range, whole, choose } = useChoice(names)
  const [box, width] = useWidth()
  const [place, setPlace] = useState<number | null>(null)
  const asked = useTrends(chosen, range, timePixels(width, true))
  const drawn = useDrawn(asked.value, range, unit, live.now)
  const window = windowOf(range, live.now)
  const cursor = place === null ? null : window[0] + place * (window[1] - window[0])
  const setRange = (range: Range): void => choose(chosen, range, whole)
  const of = (series: string): Gauge => all.find((one) => one.series === series)!.gauge
  const painted = colours(names, chosen, dark)
  const paint = (series: string): string => painted.get(series) ?? 'gray'
  const limits = limitsOf(useAsked('limits', LIMITS_MS, (signal) => alarms(signal)).value ?? [], chosen)
  const trips = drawn.trends
    .filter(({ series }) => names.includes(series))
    .flatMap(({ series }) =>
      of(series).levels.map(({ name, pa }) => ({
        name: `${series}: ${name}`,
        colour: paint(series),
        value: inUnit(pa, unit),
      })),
    )
  const levels = [
    ...trips,
    ...limits.map(({ name, priority, limit }) => ({
      name,
      colour: own(PAINTS[priority]),
      value: inUnit(limit!, unit),
    })),
  ]
  const toggle = (series: string): void =>
    choose(
      chosen.includes(series)
        ? chosen.filter((name) => name !== series)
        : names.filter((name) => name === series || chosen.includes(name)),
      range,
      whole,
    )
  return (
    <div class="trends">
      <h1 class="unseen">Trends</h1>
      <Bar
        range={range}
        now={live.now}
        whole={whole}
        setRange={setRange}
        setWhole={(whole) => choose(chosen, range, whole)}
      />
      <div class="trend-chart panel" ref={box}>
        <Chart
          words={`Pressures in ${unit} over time. Arrow keys move, plus and minus zoom, Home goes back to now.`}
          times={drawn.times}
          curves={drawn.curves}
          lines={drawn.trends.map(({ series }, place) => ({
            name: series,
            colour: paint(series),
            stretches: drawn.stretches[place]!,
          }))}
          window={window}
          scale={scaleOf(
            drawn,
            window,
            unit,
            whole,
            levels.map(({ value }) => value),
          )}
          log={true}
          unit={unit}
          levels={levels}
          marks={(asked.value?.happenings ?? []).map(({ at_ms, text }) => ({ at: at_ms, name: text }))}
          width={width}
          height={width < 600 ? 300 : Math.max(340, Math.min(720, Math.round(innerHeight * 0.52)))}
          look={dark ? 'dark' : 'light'}
          onSelect={(from, to) => setRange({ from, to: Math.max(to, from + 2000) })}
          onZoom={(at, factor) => setRange(zoomed(window, at, factor))}
          onCursor={setPlace}
          onKey={(key) => {
            const next = keyed(key, range, live.now, HOME)
            if (next) setRange(next)
            return next !== null
          }}
        />
      </div>
      <Readout
        all={all}
        chosen={chosen}
        paint={paint}
        toggle={toggle}
        unit={unit}
        at={cursor}
        read={(series) => (cursor === null ? null : readAt(drawn, series, cursor))}
        happenings={nearby(asked.value?.happenings ?? [], cursor, window, width)}
      />
      <Limits limits={limits} unit={unit} />
      <Busy asked={asked} />
      <div class="bar">
        <Custom window={window} live={isLive(range)} setRange={setRange} />
        <a
          class="button"
          href={exportAddress(chosen, Math.floor(window[0]), Math.ceil(window[1]))}
          download="pressures.csv"
        >
          Save as CSV
        </a>
      </div>
    </div>
  )
}

/** What the lines of alarms are. */
function Limits({ limits, unit }: { limits: Alarm[]; unit: Unit }): JSX.Element | null {
  if (limits.length === 0) return null
  return (
    <ul class="limits" aria-label="Alarm limits">
      {limits.map(({ name, priority, condition, limit }) => (
        <li key={name} data-limit={name}>
          <PriorityMark priority={priority} /> {name}{' '}
          <span class="muted">{`${condition} ${quantity(limit, 'Pa', unit)}`}</span>
        </li>
      ))}
    </ul>
  )
}

/** The range of the axis in the unit that is shown. */
function scaleOf(
  drawn: Drawn,
  window: [number, number],
  unit: Unit,
  whole: boolean,
  levels: number[],
): [number, number] {
  if (whole) return decades(inUnit(WHOLE[0], unit) * 1.3, inUnit(WHOLE[1], unit))
  const [low, high] = extent(drawn, window)
  const all = [low, high, ...levels].filter(Number.isFinite)
  return all.length ? decades(Math.min(...all), Math.max(...all)) : decades(1 / UNITS[unit], 1e3 / UNITS[unit])
}

/** Events under the cursor, within some pixels. */
function nearby<T extends { at_ms: number }>(
  happenings: T[],
  cursor: number | null,
  window: [number, number],
  width: number,
): T[] {
  const reach = (6 * (window[1] - window[0])) / Math.max(1, width)
  return cursor === null ? [] : happenings.filter(({ at_ms }) => Math.abs(at_ms - cursor) < reach)
}

interface BarProps {
  range: Range
  now: number
  whole: boolean
  setRange: (range: Range) => void
  setWhole: (whole: boolean) => void
}

function Bar({ range, now, whole, setRange, setWhole }: BarProps): JSX.Element {
  const window = windowOf(range, now)
  const middle = (window[0] + window[1]) / 2
  return (
    <div class="bar" role="toolbar" aria-label="Time">
      <div class="buttons">
        {SPANS.map(({ name, words, ms }) => (
          <button
            type="button"
            key={name}
            aria-pressed={isLive(range) && range.last === ms}
            onClick={() => setRange({ last: ms })}
          >
            {words}
          </button>
        ))}
      </div>
      <div class="buttons">
        <button type="button" aria-label="Earlier" onClick={() => setRange(moved(window, -0.5))}>
          ‹
        </button>
        <button type="button" aria-label="Closer" onClick={() => setRange(zoomed(window, middle, 0.5))}>
          +
        </button>
        <button type="button" aria-label="Farther" onClick={() => setRange(zoomed(window, middle, 2))}>
          −
        </button>
        <button type="button" aria-label="Later" onClick={() => setRange(moved(window, 0.5))}>
          ›
        </button>
      </div>
      <button
        type="button"
        aria-pressed={whole}
        onClick={() => setWhole(!whole)}
        title="All decades, or those that are needed"
      >
        Whole scale
      </button>
    </div>
  )
}

/** From when to when, to be typed. In a live range it says what is shown, once a second. */
function Custom({
  window,
  live,
  setRange,
}: {
  window: [number, number]
  live: boolean
  setRange: (range: Range) => void
}): JSX.Element {
  const [from, to] = window.map(inputMoment) as [string, string]
  const [draft, setDraft] = useState<[string, string] | null>(null)
  useEffect(() => setDraft(null), [live ? 0 : from, live ? 0 : to])
  const [shownFrom, shownTo] = draft ?? [from, to]
  const apply = (event: SubmitEvent): void => {
    event.preventDefault()
    const [start, end] = [Date.parse(shownFrom), Date.parse(shownTo)]
    if (end - start >= 2000) setRange({ from: start, to: end })
  }
  return (
    <form
      class="custom"
      onSubmit={apply as unknown as JSX.SubmitEventHandler<HTMLFormElement>}
      aria-label={`From ${moment(window[0])} to ${moment(window[1])}`}
    >
      <input
        type="datetime-local"
        step="1"
        aria-label="From"
        value={shownFrom}
        onInput={(event) => setDraft([event.currentTarget.value, shownTo])}
      />
      <span aria-hidden="true">–</span>
      <input
        type="datetime-local"
        step="1"
        aria-label="To"
        value={shownTo}
        onInput={(event) => setDraft([shownFrom, event.currentTarget.value])}
      />
      <button type="submit" disabled={draft === null}>
        Show
      </button>
    </form>
  )
}
