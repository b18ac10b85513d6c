// Rate of rise: the valve to the pump is closed, the pressure rises, and its shape tells a leak from outgassing.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { rise, type Rise as Fit } from '../api.ts'
import { useLive } from '../live.ts'
import { Chart, timePixels, type Line } from '../parts/chart.tsx'
import { colour } from '../parts/colours.ts'
import { Pressure } from '../parts/pressure.tsx'
import { allSeries, Busy, extent, keyed, useDrawn, useTrends } from '../parts/trend.tsx'
import { useAsked, useWidth } from '../parts/use.ts'
import { age, inputMoment, number } from '../pure/format.ts'
import { isLive, rangeOf, rangeText, windowOf, zoomed, type Range } from '../pure/range.ts'
import { fitted, verdict } from '../pure/rise.ts'
import type { Curve } from '../pure/series.ts'
import { FLOWS, inUnit, type Unit } from '../pure/units.ts'
import { ask, usePlace } from '../router.tsx'
import { useDark, useUnit } from '../settings.ts'

const HOME: Range = { last: 30 * 60_000 }

/** How often a rise that goes on is fitted again. */
const AGAIN_MS = 2_000

interface Wanted {
  series: string
  begin: number | null
  end: number | null
  litres: string
}

/** What the address of the page says: a measurement can be kept as a bookmark. */
function useWanted(first: string): [Wanted, (wanted: Wanted) => void] {
  const { query } = usePlace()
  const time = (name: string): number | null => (query.get(name) ? Number(query.get(name)) : null)
  const wanted = {
    series: query.get('s') ?? first,
    begin: time('begin'),
    end: time('end'),
    litres: query.get('litres') ?? '',
  }
  const change = ({ series, begin, end, litres }: Wanted): void => {
    const next = new URLSearchParams(query.has('range') || query.has('from') ? rangeText(rangeOf(query)) : {})
    next.set('s', series)
    if (begin !== null) next.set('begin', String(Math.round(begin)))
    if (end !== null) next.set('end', String(Math.round(end)))
    if (litres) next.set('litres', litres)
    ask(next)
  }
  return [wanted, change]
}

export function Rise(): JSX.Element {
  const live = useLive()
  const names = allSeries(live.moment!.gauges).map(({ series }) => series)
  const [wanted, change] = useWanted(names[0] ?? '')
  const { series, begin, end, litres } = wanted
  const volume = Number(litres) > 0 ? Number(litres) / 1000 : null
  const ready = begin !== null && (end ?? live.now) > begin
  const fit = useAsked(JSON.stringify(wanted), ready && end === null ? AGAIN_MS : null, async () =>
    ready ? rise(series, begin, Math.round(end ?? live.now), volume) : null,
  )
  return (
    <div class="rise">
      <h1>Rate of rise</h1>
      <ol class="steps panel">
        <li>
          <label>
            <span>Choose the gauge</span>
            <select
              value={series}
              onChange={(event) => change({ ...wanted, series: event.currentTarget.value, begin: null, end: null })}
            >
              {names.map((name) => (
                <option value={name} key={name}>
                  {name}
                </option>
              ))}
            </select>
          </label>
        </li>
        <li>
          <Moment
            words="Close the valve to the pump and mark the beginning"
            button="It closes now"
            at={begin}
            now={live.now}
            set={(at) => change({ ...wanted, begin: at, end: null })}
          />
        </li>
        <li>
          <Moment
            words="Wait, then mark the end"
            button="It ends now"
            at={end}
            now={live.now}
            set={(at) => change({ ...wanted, end: at })}
          />
        </li>
        <li>
          <label>
            <span>Give the volume, for flows</span>
            <input
              class="short"
              type="number"
              min="0"
              step="any"
              inputMode="decimal"
              value={litres}
              onInput={(event) => change({ ...wanted, litres: event.currentTarget.value })}
            />{' '}
            L
          </label>
        </li>
      </ol>
      <Curves
        wanted={wanted}
        fit={ready ? fit.value : null}
        mark={(from, to) => change({ ...wanted, begin: from, end: to })}
      />
      <Result fit={ready ? fit.value : null} error={ready ? fit.error : null} volume={volume} />
    </div>
  )
}

interface MomentProps {
  words: string
  button: string
  at: number | null
  now: number
  set: (at: number) => void
}

function Moment({ words, button, at, now, set }: MomentProps): JSX.Element {
  const typed = (text: string): void => {
    const time = Date.parse(text)
    if (Number.isFinite(time)) set(time)
  }
  return (
    <div class="moment">
      <span>{words}</span>
      <button type="button" class="main" onClick={() => set(now)}>
        {button}
      </button>
      <input
        type="datetime-local"
        step="1"
        aria-label={words}
        value={at === null ? '' : inputMoment(at)}
        onChange={(event) => typed(event.currentTarget.value)}
      />
    </div>
  )
}

function Curves({
  wanted,
  fit,
  mark,
}: {
  wanted: Wanted
  fit: Fit | null
  mark: (from: number, to: number) => void
}): JSX.Element {
  const live = useLive()
  const unit = useUnit()
  const dark = useDark()
  const [box, width] = useWidth()
  const [zoom, setZoom] = useState<Range | null>(null)
  const range = zoom ?? around(wanted, live.now)
  const asked = useTrends([wanted.series], range, timePixels(width, false))
  const drawn = useDrawn(asked.value, range, unit, live.now)
  const window = windowOf(range, live.now)
  const measured = colour(0, dark)
  const lines: Line[] = drawn.trends.map(({ series }, place) => ({
    name: series,
    colour: measured,
    stretches: drawn.stretches[place]!,
  }))
  const curves = [...drawn.curves]
  if (fit && wanted.begin !== null && lines.length > 0) {
    curves.push(fittedCurve(fit, drawn.times, wanted.begin, wanted.end ?? live.now, unit))
    lines.push({ name: 'fit', colour: colour(1, dark), dashed: true, stretches: [] })
  }
  const marks = [
    ...(wanted.begin === null ? [] : [{ at: wanted.begin, name: 'valve closed', strong: true }]),
    ...(wanted.end === null ? [] : [{ at: wanted.end, name: 'end', strong: true }]),
  ]
  return (
    <div class="panel" ref={box}>
      <p class="muted hint">
        Or drag over the rise in the curve. The wheel and + − zoom, the arrows move.
        {fit && (
          <span class="fit" style={{ color: colour(1, dark) }}>
            ╌╌ fit
          </span>
        )}
      </p>
      <Chart
        words={`The pressure of ${wanted.series} in ${unit} over time. Dragging marks beginning and end.`}
        times={drawn.times}
        curves={curves}
        lines={lines}
        window={window}
        scale={linear(extent(drawn, window))}
        log={false}
        unit={unit}
        marks={marks}
        width={width}
        height={300}
        look={dark ? 'dark' : 'light'}
        onSelect={mark}
        onZoom={(at, factor) => setZoom(zoomed(window, at, factor))}
        onKey={(key) => {
          const next = keyed(key, range, live.now, HOME)
          if (next) setZoom(isLive(next) ? null : next)
          return next !== null
        }}
      />
      <Busy asked={asked} />
    </div>
  )
}

/** The rise with something on both sides, once it is marked. */
function around({ begin, end }: Wanted, now: number): Range {
  if (begin === null || end === null) return HOME
  const room = Math.max(5_000, (end - begin) * 0.25)
  return { from: begin - room, to: Math.min(now, end + room) }
}

function linear([low, high]: [number, number]): [number, number] {
  if (!Number.isFinite(low)) return [0, 1]
  const room = (high - low || high) * 0.08
  return [Math.max(0, low - room), high + room]
}

function fittedCurve(fit: Fit, times: number[], begin: number, end: number, unit: Unit): Curve {
  const mean = times.map((time) =>
    time < begin || time > end ? null : inUnit(fitted(fit, (time - begin) / 1000), unit),
  )
  const nothing = times.map(() => null)
  return { low: nothing, high: nothing, mean }
}

function Result({ fit, error, volume }: { fit: Fit | null; error: string | null; volume: number | null }): JSX.Element {
  const unit = useUnit()
  if (error) return <p class="alarm">{error}</p>
  if (!fit) return <p class="panel muted">What it means stands here as soon as beginning and end are marked.</p>
  const { title, sentence } = verdict(fit)
  return (
    <section class="panel result" aria-label="Result" role="status">
      <h2>{title}</h2>
      <p>{sentence}</p>
      <dl class="facts">
        <Fact name="steady rise">
          <Pressure pa={fit.steady_pa_per_s} unit={unit} />
          /s
        </Fact>
        {fit.bend_pa !== null && fit.tau_s !== null && (
          <Fact name="flattening part">
            <Pressure pa={fit.bend_pa} unit={unit} />, 63 % after {age(fit.tau_s * 1000)}
          </Fact>
        )}
        <Fact name="fit explains">{(fit.explained * 100).toFixed(1)} %</Fact>
        <Fact name="samples">{fit.samples}</Fact>
      </dl>
      {volume === null ? <p class="muted">With the volume, flows are given as well.</p> : <Flows fit={fit} />}
    </section>
  )
}

function Fact({ name, children }: { name: string; children: preact.ComponentChildren }): JSX.Element {
  return (
    <div>
      <dt>{name}</dt>
      <dd>{children}</dd>
    </div>
  )
}

function Flows({ fit }: { fit: Fit }): JSX.Element {
  const rows: [string, number | null][] = [
    ['leak', fit.leak_pa_m3_per_s],
    ['outgassing, at the beginning', fit.outgassing_pa_m3_per_s],
  ]
  return (
    <table class="flows">
      <thead>
        <tr>
          <th>Flow</th>
          {FLOWS.map(({ name }) => (
            <th key={name}>{name}</th>
          ))}
        </tr>
      </thead>
      <tbody>
        {rows.map(([name, flow]) => (
          <tr key={name}>
            <th scope="row">{name}</th>
            {FLOWS.map(({ name, factor }) => (
              <td key={name}>{flow === null ? 'cannot be told' : number(flow * factor)}</td>
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  )
}
