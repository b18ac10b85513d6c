// The user's own drawing of the plant: the station has checked it, and the elements that name gauges, volumes, valves and pumps are live.

import type { JSX } from 'preact'
import { useLayoutEffect, useRef, useState } from 'preact/hooks'
import type { Gauge, PlantPicture, Reading } from '../api/types.ts'
import { activeCounts } from '../lib/alarms.ts'
import { alarmsText, isBound, shade, shownPressure, stateWords, type VolumeState, volumeState } from '../lib/picture.ts'
import { currentQuality } from '../lib/stale.ts'
import { useLive, usePartStates, useSnapshot } from '../live.ts'
import { gaugePath, go } from '../router.tsx'
import { useUnit } from '../settings.ts'
import { t } from '../texts/texts.ts'
import STYLE from './own-drawing.css?inline'
import { readingWords } from './reading-words.ts'

/** The part of a fill that is dark at the atmosphere, in percent. */
const DARKEST = 45

/** What an element names. */
const KINDS = ['gauge', 'volume', 'part'] as const
type Kind = (typeof KINDS)[number]

/** What an element of the drawing shows: a sentence, the pressure if it is a text, and attributes for the styles. */
interface Shown {
  label: string
  text?: string
  quality?: string | undefined
  alarm?: string | undefined
  state?: string | undefined
  shade?: number | null
  /** `end` for the end of a range. */
  bound?: 'end' | undefined
}

export function OwnDrawing({ plant, drawing }: { plant: PlantPicture; drawing: string }): JSX.Element {
  const host = useRef<HTMLDivElement>(null)
  const [svg, setSvg] = useState<Element | null>(null)
  const shown = useShown(plant)
  useLayoutEffect(() => {
    if (!host.current) return
    const root = host.current.shadowRoot ?? host.current.attachShadow({ mode: 'open' })
    const style = document.createElement('style')
    style.textContent = STYLE
    const drawn = document.importNode(new DOMParser().parseFromString(drawing, 'image/svg+xml').documentElement, true)
    for (const kind of KINDS) for (const element of named(drawn, kind)) freeColours(element)
    for (const element of named(drawn, 'gauge')) makeLink(element)
    drawn.prepend(hatching(drawn))
    // The styles come last: those of the drawing are as strong.
    root.replaceChildren(drawn, style)
    keepReadable(drawn)
    setSvg(drawn)
  }, [drawing])
  useLayoutEffect(() => {
    if (!svg) return
    for (const kind of KINDS)
      for (const element of named(svg, kind)) show(element, shown[kind](element.dataset[kind] ?? ''))
  })
  return (
    // biome-ignore lint/a11y/useSemanticElements: a drawing with links is no fieldset
    <div class="own-drawing" ref={host} role="group" aria-label={t.plant.drawing} />
  )
}

/** What the elements show now, by kind and name. */
function useShown(plant: PlantPicture): Record<Kind, (name: string) => Shown> {
  const live = useLive()
  const unit = useUnit()
  const { gauges, alarms } = useSnapshot()
  const states = usePartStates()
  const quality = (gauge: Gauge, reading: Reading) => currentQuality(gauge, reading, live.since)
  const stateOf = (name: string, of: string[]): VolumeState =>
    volumeState({ name, zone: null, gauges: of }, new Set(), gauges, alarms.alarms, quality)
  const pressure = (name: string, { leading, alarms }: VolumeState): Shown & { text: string } => {
    const text = leading ? readingWords(leading, unit) : t.common.noData
    const label = [`${name}: ${text}`, alarmsText(alarms)].filter(Boolean).join(', ')
    return { label, text, quality: leading?.quality ?? 'stale', alarm: activeCounts(alarms)[0]?.priority }
  }
  return {
    gauge: (name) => pressure(name, stateOf(name, [name])),
    volume: (name) => {
      const state = stateOf(name, plant.volumes.find((volume) => volume.name === name)?.gauges ?? [])
      const { text: _, ...shown } = pressure(name, state)
      const { leading } = state
      const bound = leading && isBound(leading) ? 'end' : undefined
      return { ...shown, shade: leading && shade(shownPressure(leading)), bound }
    },
    part: (name) => {
      const part = plant.parts.find((part) => part.name === name)
      if (!part) return { label: name }
      const status = states[name] ?? undefined
      return {
        label: `${name}: ${t.plant.kinds[part.kind]}, ${stateWords(part, status)}`,
        state: status?.state ?? 'not-reported',
      }
    },
  }
}

const named = (svg: Element, kind: Kind): NodeListOf<SVGElement> => svg.querySelectorAll<SVGElement>(`[data-${kind}]`)

/** The least height of the letters of a pressure, in pixels. chosen: below it a phone scrolls. */
const LEAST_LETTERS = 11

/** A drawing is at least so wide that its pressures can be read. */
function keepReadable(drawn: Element): void {
  const sizes = [...named(drawn, 'gauge')]
    .filter(({ localName }) => localName === 'text')
    .map((text) => Number.parseFloat(getComputedStyle(text).fontSize))
    .filter((size) => size > 0)
  const { width } = (drawn as SVGSVGElement).viewBox.baseVal
  if (sizes.length > 0)
    (drawn as SVGSVGElement).style.minWidth = `${Math.round((width * LEAST_LETTERS) / Math.min(...sizes))}px`
}

/** Editors write colours into the style of an element, where the colours of a state could not replace them: an attribute is weaker. */
function freeColours(element: SVGElement): void {
  for (const property of ['fill', 'stroke', 'stroke-width']) {
    const value = element.style.getPropertyValue(property)
    if (value) element.setAttribute(property, value)
    element.style.removeProperty(property)
  }
}

const SVG = 'http://www.w3.org/2000/svg'

/** Stripes across the width of a drawing. chosen: they are a few pixels wide, whatever the units of the drawing are. */
const STRIPES = 120

/** The hatching of a volume that shows the end of a range; the styles name it. */
function hatching(drawn: Element): SVGElement {
  const size = (drawn as SVGSVGElement).viewBox.baseVal.width / STRIPES
  const pattern = document.createElementNS(SVG, 'pattern')
  const attributes = { width: size, height: size, patternUnits: 'userSpaceOnUse', patternTransform: 'rotate(45)' }
  for (const [name, value] of Object.entries({ id: 'profivac-hatching', ...attributes }))
    pattern.setAttribute(name, String(value))
  for (const [part, width] of [
    ['ground', size],
    ['stripe', size / 2],
  ] as const) {
    const stripe = document.createElementNS(SVG, 'rect')
    for (const [name, value] of Object.entries({ class: part, width, height: size }))
      stripe.setAttribute(name, String(value))
    pattern.append(stripe)
  }
  return pattern
}

/** A gauge leads to its page, by mouse and by key; a channel to that of its controller. */
function makeLink(element: SVGElement): void {
  const name = (element.dataset.gauge ?? '').replace(/\.\d+$/, '')
  element.setAttribute('role', 'link')
  element.setAttribute('tabindex', '0')
  element.addEventListener('click', () => go(gaugePath(name)))
  element.addEventListener('keydown', ({ key }) => key === 'Enter' && go(gaugePath(name)))
}

function show(element: SVGElement, { label, text, quality, alarm, state, shade, bound }: Shown): void {
  if (element.dataset.gauge === undefined) element.setAttribute('role', 'img')
  element.setAttribute('aria-label', label)
  if (element.localName === 'text' && text !== undefined && element.textContent !== text) element.textContent = text
  for (const [key, value] of Object.entries({ quality, alarm, state, bound }))
    if (value === undefined) delete element.dataset[key]
    else element.dataset[key] = value
  if (shade === undefined) return
  if (shade === null) element.style.removeProperty('--shade')
  else element.style.setProperty('--shade', `${(shade * DARKEST).toFixed(0)}%`)
}
