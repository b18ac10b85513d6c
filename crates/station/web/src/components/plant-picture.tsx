// The plant as a picture: volumes with their leading pressure, valves and pumps with their states, zones with their alarms.

import './plant-picture.css'
import type { JSX } from 'preact'
import { useEffect, useState } from 'preact/hooks'
import { fetchPlant } from '../api/calls.ts'
import type {
  Alarm,
  Gauge,
  LivePlant,
  PlantPart,
  PlantPartStatus,
  PlantPicture,
  PlantVolume,
  Priority,
} from '../api/types.ts'
import { activeCounts, byUrgency, countsText, lowerText, NUMBERS, type PriorityCount } from '../lib/alarms.ts'
import { clock, decade, number } from '../lib/format.ts'
import {
  alarmsText,
  countsOf,
  isBound,
  isForBothThemes,
  isHidden,
  namesIn,
  passes,
  SHADES,
  shade,
  shownPressure,
  stateWords,
  topOf,
  type VolumeState,
  volumeNode,
  volumeState,
  zonesOf,
} from '../lib/picture.ts'
import type { Box, Direction, Layout, Point } from '../lib/plant-layout.ts'
import { currentQuality } from '../lib/stale.ts'
import { UNITS, type Unit } from '../lib/units.ts'
import { useLive, usePartStates, useSnapshot } from '../live.ts'
import { gaugePath, go } from '../router.tsx'
import { useUnit } from '../settings.ts'
import { t } from '../texts/texts.ts'
import { AlarmCounts } from './alarm-marks.tsx'
import { errorText, type Query, usePageWidth, useQuery, useWidth } from './hooks.ts'
import { OwnDrawing } from './own-drawing.tsx'
import { readingWords } from './reading-words.ts'

/** A plant that has room is drawn up to this much larger. */
const LARGEST = 1.5

/** A picture up to this wide leaves two thirds of a page to what stands beside it, in pixels. */
const NARROW = 420

/** What the page and the panel of a picture leave free at both sides, in pixels. */
const FRAME = 72

/** The plant of the station's file; fetched again when it changes. */
export function usePlant(): { plant: PlantPicture | null; error: string | null; query: Query<PlantPicture> } {
  const { plant } = useSnapshot()
  const query = useQuery(String(plant.revision), null, fetchPlant)
  return { plant: query.value, error: query.error, query }
}

/** The state of every volume, now. */
export function useVolumes(plant: PlantPicture): { volume: PlantVolume; state: VolumeState }[] {
  const live = useLive()
  const { gauges, alarms } = useSnapshot()
  const named = namesIn(plant)
  const quality = (gauge: Gauge, reading: Gauge['readings'][number]) => currentQuality(gauge, reading, live.since)
  return plant.volumes.map((volume) => ({
    volume,
    state: volumeState(volume, named, gauges, alarms.alarms, quality),
  }))
}

/** Whether there is a picture. */
export const hasPicture = ({ volumes, drawing }: PlantPicture): boolean => volumes.length > 0 || Boolean(drawing)

/** The user's own drawing, or the picture from the file, with the scale of its shades. */
export function Picture({ plant }: { plant: PlantPicture }): JSX.Element {
  return (
    <>
      <ZonesWithAlarms plant={plant} />
      {plant.drawing ? <Drawn plant={plant} drawing={plant.drawing} /> : <LaidOut plant={plant} />}
      {!plant.drawing && <ShadeScale />}
    </>
  )
}

/** The user's own drawing and the scale of its shades: on a white sheet, unless it is made for both themes. */
function Drawn({ plant, drawing }: { plant: PlantPicture; drawing: string }): JSX.Element {
  return (
    <div class="drawn" data-sheet={isForBothThemes(drawing) ? undefined : ''}>
      <OwnDrawing plant={plant} drawing={drawing} />
      <ShadeScale />
    </div>
  )
}

/** The zones with an active alarm, the most urgent first: a large picture may have them outside of the window. */
function ZonesWithAlarms({ plant }: { plant: PlantPicture }): JSX.Element | null {
  const volumes = useVolumes(plant)
  const zones = zonesOf(plant)
    .map((zone) => {
      const alarms = volumes.filter(({ volume }) => volume.zone === zone).flatMap(({ state }) => state.alarms)
      return { zone, alarms: alarms.sort(byUrgency) }
    })
    .flatMap(({ zone, alarms }) => alarms.slice(0, 1).map((urgent) => ({ zone, alarms, urgent })))
    .sort((one, other) => byUrgency(one.urgent, other.urgent))
  if (zones.length === 0) return null
  return (
    <ul class="zones-with-alarms" aria-label={t.plant.zonesWithAlarms}>
      {zones.map(({ zone, alarms }) => (
        <li key={zone}>
          <strong>{zone}</strong>: <AlarmCounts counts={activeCounts(alarms)} />
        </li>
      ))}
    </ul>
  )
}

/** The picture from the file, as soon as it is laid out. */
function LaidOut({ plant }: { plant: PlantPicture }): JSX.Element {
  const [ref, width] = useWidth()
  const page = usePageWidth()
  const { layouts, error } = useLayouts(plant)
  const layout = layouts && (layouts.LR.width <= page - FRAME ? layouts.LR : layouts.TB)
  return (
    <div
      class="plant-picture"
      ref={ref}
      data-direction={layout?.direction}
      data-narrow={layout && layout.width <= NARROW}
    >
      {error && <p class="error">{error}</p>}
      {layout && width > 0 && <Drawing plant={plant} layout={layout} width={drawnWidth(layout, width)} />}
    </div>
  )
}

/** The width of the drawing: its texts are never smaller than laid out; a picture wider than the page scrolls. */
function drawnWidth({ direction, width }: Layout, room: number): number {
  return direction === 'LR' ? Math.max(width, Math.min(room, width * LARGEST)) : width
}

type Layouts = Record<Direction, Layout>

function useLayouts(plant: PlantPicture): { layouts: Layouts | null; error: string | null } {
  const [state, setState] = useState<{ layouts: Layouts | null; error: string | null }>({ layouts: null, error: null })
  useEffect(() => {
    let isWanted = true
    import('../lib/plant-layout.ts')
      .then(({ laidOut }) => {
        const layouts = { LR: laidOut(plant, 'LR'), TB: laidOut(plant, 'TB') }
        if (isWanted) setState({ layouts, error: null })
      })
      .catch((error: unknown) => isWanted && setState({ layouts: null, error: errorText(error) }))
    return () => {
      isWanted = false
    }
  }, [plant])
  return state
}

function Drawing(props: { plant: PlantPicture; layout: Layout; width: number }): JSX.Element {
  const { plant, layout, width } = props
  const volumes = useVolumes(plant)
  const states = usePartStates()
  const boxOf = (id: string): Box | undefined => layout.boxes.get(id)
  const top = topOf(
    layout,
    plant.parts.filter((part) => isHidden(part, states[part.name] ?? undefined)),
  )
  return (
    // biome-ignore lint/a11y/useSemanticElements: an SVG has no element for a group of links
    <svg
      viewBox={`0 ${top} ${layout.width} ${layout.height - top}`}
      width={width}
      role="group"
      aria-label={t.plant.picture}
    >
      {layout.zones.map(({ name, box }) => (
        <Zone
          name={name}
          box={box}
          alarms={volumes.filter(({ volume }) => volume.zone === name).flatMap(({ state }) => state.alarms)}
          key={name}
        />
      ))}
      {layout.lines.map(({ part, points }, index) => (
        <polyline
          class={`line ${lineClass(plant, part, states)}`}
          points={points.map(({ x, y }) => `${x.toFixed(1)},${y.toFixed(1)}`).join(' ')}
          key={index}
        />
      ))}
      {volumes.map(({ volume, state }) => {
        const box = boxOf(volumeNode(volume.name))
        return box && <Volume name={volume.name} state={state} box={box} key={volume.name} />
      })}
      {plant.parts.map((part) => {
        const at = layout.symbols.get(part.name)
        return (
          at && (
            <Part
              part={part}
              status={states[part.name] ?? undefined}
              at={at}
              direction={layout.direction}
              key={part.name}
            />
          )
        )
      })}
    </svg>
  )
}

function lineClass({ parts }: PlantPicture, name: string, states: LivePlant['states']): string {
  const part = parts.find((part) => part.name === name)
  if (!part) return ''
  const status = states[name] ?? undefined
  if (isHidden(part, status)) return 'hidden'
  const passing = passes(part, status)
  return passing === null ? 'unreported' : passing ? 'open' : 'closed'
}

/** The shape of a priority with its number, as in the list of alarms. */
function AlarmShape({ priority, x, y }: { priority: Priority; x: number; y: number }): JSX.Element {
  const shape = {
    high: <rect x={x - 8} y={y - 8} width="16" height="16" />,
    medium: <polygon points={`${x},${y - 11} ${x + 11},${y} ${x},${y + 11} ${x - 11},${y}`} />,
    low: <circle cx={x} cy={y} r="9" />,
  }[priority]
  return (
    <g class={`alarm-shape ${priority}`}>
      {shape}
      <text x={x} y={y + 4} text-anchor="middle">
        {NUMBERS[priority]}
      </text>
    </g>
  )
}

function Zone({ name, box, alarms }: { name: string; box: Box; alarms: Alarm[] }): JSX.Element {
  const [highest] = activeCounts(alarms)
  const [left, top] = [box.x - box.width / 2, box.y - box.height / 2]
  return (
    <g class={`zone ${highest?.priority ?? ''}`} data-zone={name}>
      <rect x={left} y={top} width={box.width} height={box.height} rx="10" />
      {highest && <AlarmShape priority={highest.priority} x={left + 20} y={top + 11} />}
      <text x={left + (highest ? 36 : 10)} y={top + 15}>
        {[name, alarmsText(alarms)].filter(Boolean).join(', ')}
      </text>
    </g>
  )
}

function Volume({ name, state, box }: { name: string; state: VolumeState; box: Box }): JSX.Element {
  const unit = useUnit()
  const { leading, silent, alarms } = state
  const [left, top] = [box.x - box.width / 2, box.y - box.height / 2]
  const dark = leading && shade(shownPressure(leading))
  const counts = activeCounts(alarms)
  const [highest] = counts
  const { shown: series, all, without } = countsOf(state)
  const value = leading ? readingWords(leading, unit) : silent.length > 0 ? t.common.noData : t.qualities.missing
  const from = series + (all > 1 ? t.plant.more(all - 1) : '')
  // The only reading says so itself.
  const missing = all > 1 && without > 0 ? t.plant.without(without, all) : ''
  // The texts in the order in which they are seen (WCAG 2.2, 2.5.3).
  const urgent = highest && `${NUMBERS[highest.priority]}: ${shortCounts(counts)}`
  const label = [`${name}: ${value}`, from, missing, urgent].filter(Boolean).join(', ')
  const shown = (
    <>
      <rect class="volume-ground" x={left} y={top} width={box.width} height={box.height} rx="14" />
      {dark !== null && (
        <rect
          class={shadeClass(leading !== null && isBound(leading))}
          x={left}
          y={top}
          width={box.width}
          height={box.height}
          rx="14"
          fill-opacity={shadeOpacity(dark)}
        />
      )}
      <rect
        class={`volume-edge ${leading?.quality ?? 'stale'} ${highest?.priority ?? ''}`}
        x={left}
        y={top}
        width={box.width}
        height={box.height}
        rx="14"
      />
      {/* The spaces part the texts for a screen reader. */}
      <text class="name" x={left + 14} y={top + 21}>
        {name}
      </text>{' '}
      <text class={`value ${leading?.quality ?? 'stale'}`} x={left + 14} y={top + 46}>
        {value.replace(` ${unit}`, '')}
        {value.endsWith(` ${unit}`) && <tspan class="unit"> {unit}</tspan>}
      </text>{' '}
      <text class="from" x={left + 14} y={top + 66}>
        {from}
      </text>{' '}
      <text class="from missing" x={left + 14} y={top + 83}>
        {missing}
      </text>{' '}
      <VolumeAlarms counts={counts} x={left + 14} y={top + 99} />
      {dark !== null && <Decades part={dark} isBound={leading !== null && isBound(leading)} box={box} />}
    </>
  )
  return leading ? (
    <GaugeLink gauge={leading.gauge.name} label={label} volume={name}>
      {shown}
    </GaugeLink>
  ) : (
    <g data-volume={name}>{shown}</g>
  )
}

/** Where the pressure is between the lowest and the highest decade: volumes compare at a glance. The end of a range is hollow. */
function Decades({ part, isBound, box }: { part: number; isBound: boolean; box: Box }): JSX.Element {
  const [left, width] = [box.x - box.width / 2 + 14, box.width - 28]
  const y = box.y + box.height / 2 - 9
  return (
    <g class={`decades ${isBound ? 'bound' : ''}`}>
      <line x1={left} x2={left + width} y1={y} y2={y} />
      {SCALE.map((exponent) => {
        const x = left + (shade(10 ** exponent) ?? 0) * width
        return <line x1={x} x2={x} y1={y - 3} y2={y + 3} key={exponent} />
      })}
      <circle cx={left + part * width} cy={y} r="4" />
    </g>
  )
}

/** `1 high, 3 medium`, or `1 high, 5 more` with all three priorities. */
const shortCounts = ([highest, ...lower]: PriorityCount[]): string =>
  highest ? [countsText([highest]), lowerText(lower)].filter(Boolean).join(', ') : ''

/** The shape of the highest priority, and the number of alarms in words. */
function VolumeAlarms({ counts, x, y }: Point & { counts: PriorityCount[] }): JSX.Element | null {
  const [highest] = counts
  if (!highest) return null
  return (
    <>
      <AlarmShape priority={highest.priority} x={x + 10} y={y} />{' '}
      <text class="words" x={x + 26} y={y + 5}>
        {shortCounts(counts)}
      </text>
    </>
  )
}

function GaugeLink(props: { gauge: string; label: string; volume: string; children: JSX.Element }): JSX.Element {
  const to = gaugePath(props.gauge)
  const follow = (event: MouseEvent): void => {
    if (event.ctrlKey || event.metaKey || event.shiftKey || event.button !== 0) return
    event.preventDefault()
    go(to)
  }
  return (
    <a href={to} onClick={follow} aria-label={props.label} data-volume={props.volume}>
      {props.children}
    </a>
  )
}

/** The half size of a symbol. */
const R = 15

interface PartProps {
  part: PlantPart
  /** What is reported about it. */
  status: PlantPartStatus | undefined
  at: Point
  direction: Direction
}

function Part({ part, status, at: { x, y }, direction }: PartProps): JSX.Element | null {
  const passing = passes(part, status)
  const words = stateWords(part, status)
  if (isHidden(part, status)) return null
  const state = passing === null ? 'unreported' : passing ? 'open' : 'closed'
  const wordsAt =
    direction === 'LR'
      ? ({ x, y: y + R + 15, 'text-anchor': 'middle' } as const)
      : ({ x: x + R + 12, y: y - 3, 'text-anchor': 'start' } as const)
  return (
    <g class={`part ${part.kind} ${state}`} data-part={part.name}>
      <title>{`${t.plant.kinds[part.kind]} ${part.name}: ${words}`}</title>
      <PartSymbol kind={part.kind} x={x} y={y} />
      <text class="name" {...wordsAt}>
        {part.name}
      </text>
      <text class="state" {...wordsAt} y={wordsAt.y + 16}>
        {words}
      </text>
    </g>
  )
}

/** Symbols as on plans of vacuum plants: two triangles for a valve, a circle with two lines for a pump. */
function PartSymbol({ kind, x, y }: { kind: PlantPart['kind']; x: number; y: number }): JSX.Element {
  switch (kind) {
    case 'tube':
      return <rect x={x - R} y={y - 4} width={2 * R} height="8" rx="4" />
    case 'valve':
      return (
        <path
          d={`M${x - R - 4},${y - R + 3} L${x},${y} L${x - R - 4},${y + R - 3} Z M${x + R + 4},${y - R + 3} L${x},${y} L${x + R + 4},${y + R - 3} Z`}
        />
      )
    case 'roughing-pump':
    case 'turbo-pump':
    case 'capture-pump':
      return (
        <>
          <circle cx={x} cy={y} r={R} />
          <path class="blades" d={pumpLines(kind, x, y)} />
        </>
      )
    case 'leak':
      return (
        <>
          <polygon points={`${x},${y - R} ${x + R + 2},${y + R - 2} ${x - R - 2},${y + R - 2}`} />
          <text class="mark" x={x} y={y + R - 6} text-anchor="middle">
            !
          </text>
        </>
      )
    case 'vent':
    case 'inlet':
      return <path d={`M${x - R},${y - R + 4} L${x + R},${y} L${x - R},${y + R - 4} Z`} />
  }
}

function pumpLines(kind: 'roughing-pump' | 'turbo-pump' | 'capture-pump', x: number, y: number): string {
  switch (kind) {
    case 'turbo-pump':
      return `M${x - 9},${y - 7} L${x + 9},${y - 3} M${x - 9},${y} L${x + 9},${y + 4} M${x - 9},${y + 7} L${x + 5},${y + 10}`
    case 'roughing-pump':
      return `M${x - 12},${y - 8} L${x + 14},${y - 3} M${x - 12},${y + 8} L${x + 14},${y + 3}`
    case 'capture-pump':
      return `M${x},${y - 10} L${x},${y + 10} M${x - 10},${y} L${x + 10},${y}`
  }
}

/** How dark a shade is drawn, from 0 for the lowest pressure to 1: texts on the darkest one keep a contrast of 4.5 in light and dark. */
const shadeOpacity = (dark: number): string => (0.02 + 0.53 * dark).toFixed(2)

/** The end of a range is hatched: the pressure itself may be far from it. */
const shadeClass = (isBound: boolean): string => `volume-shade ${isBound ? 'bound' : ''}`

/** The powers of ten in Pa that the scale of the shades and the lines of the volumes have. */
const SCALE = [SHADES[0], -5, -2, 1, SHADES[1]]

/** The scale of the shades, with its decades and the hatching of an end of a range, which is defined here for the picture too. */
function ShadeScale(): JSX.Element {
  const unit = useUnit()
  const high = SHADES[1]
  return (
    <p class="shade-scale">
      <span class="muted">{t.plant.shade(unit)}</span>
      {SCALE.map((exponent) => (
        <span class="shade-step" key={exponent}>
          <ShadeSample dark={shade(10 ** exponent) ?? 0} isBound={false} />
          {exponent === high ? number(10 ** exponent / UNITS[unit]) : decadeText(exponent, unit)}
        </span>
      ))}
      <span class="shade-step">
        <ShadeSample dark={1} isBound={true} />
        {t.plant.bound}
      </span>
    </p>
  )
}

function ShadeSample({ dark, isBound }: { dark: number; isBound: boolean }): JSX.Element {
  return (
    <svg viewBox="0 0 28 16" width="28" height="16" aria-hidden="true">
      {isBound && <Hatching />}
      <rect class="volume-ground" width="28" height="16" rx="3" />
      <rect class={shadeClass(isBound)} width="28" height="16" rx="3" fill-opacity={shadeOpacity(dark)} />
      <rect class="volume-edge valid" x="0.5" y="0.5" width="27" height="15" rx="3" />
    </svg>
  )
}

/** The stripes of an end of a range; styles name it. */
const Hatching = (): JSX.Element => (
  <pattern id="hatching" width="8" height="8" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
    <rect class="volume-shade" width="4" height="8" />
  </pattern>
)

const decadeText = (exponent: number, unit: Unit): string => {
  const value = 10 ** exponent / UNITS[unit]
  const isDecade = Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-6
  return isDecade ? decade(value) : number(value)
}

/** What happens in a demonstration, the latest sentence first. */
export function Story({ now }: { now: LivePlant }): JSX.Element | null {
  const [latest, ...before] = now.story
  if (!latest) return null
  return (
    <section class="story" aria-label={t.plant.story}>
      <p class="story-latest" role="status">
        <span class="story-time">{clock(latest.at_ms)}</span> <span lang="en">{latest.text}</span>
      </p>
      {before.length > 0 && (
        <details>
          <summary>{t.plant.before}</summary>
          <ol>
            {before.map(({ at_ms, text }) => (
              <li key={at_ms}>
                <span class="story-time">{clock(at_ms)}</span> <span lang="en">{text}</span>
              </li>
            ))}
          </ol>
        </details>
      )}
    </section>
  )
}
