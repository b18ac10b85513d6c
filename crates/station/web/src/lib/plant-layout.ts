// Places the plant with dagre. This module is loaded with the first picture, because the library is as large as the rest of the page.

import { Graph, layout } from '@dagrejs/dagre'
import type { PlantPart, PlantPicture } from '../api/types.ts'
import { linesOf, partNode, volumeNode, zonesOf } from './picture.ts'

export interface Point {
  x: number
  y: number
}

/** A box, by its centre and its size. */
export interface Box extends Point {
  width: number
  height: number
}

export interface Layout {
  direction: Direction
  width: number
  height: number
  boxes: Map<string, Box>
  /** Where the symbol of each part is, by the name of the part. */
  symbols: Map<string, Point>
  zones: { name: string; box: Box }[]
  lines: { part: string; points: Point[] }[]
}

/** The size of a volume: the longest pressure fits in, `< 3.75 × 10⁻² micron`, between the name and three lines of words, above the line of the decades. */
const VOLUME = { width: 212, height: 128 }

/** The size of a part: its symbol, and its words below it, or to the right of it beside a line that goes down. */
const PART = { LR: { width: 76, height: 96 }, TB: { width: 142, height: 50 } }

/** How far the symbol of a part is beside the centre of its box. */
const SYMBOL_X = { LR: 0, TB: -50 }

/** The room between volumes and parts, along the direction and across it. */
const ROOM = { LR: { ranksep: 14, nodesep: 22 }, TB: { ranksep: 20, nodesep: 6 } }

/** The name of a zone needs this height above its volumes. */
const ZONE_NAME = 20

export type Direction = keyof typeof PART

const zoneNode = (name: string): string => `zone ${name}`

/** From left to right, or from top to bottom on a narrow page. */
export function laidOut(plant: PlantPicture, direction: Direction): Layout {
  const graph = new Graph({ compound: true, multigraph: true })
  const marginy = zonesOf(plant).length > 0 ? ZONE_NAME : 8
  graph.setGraph({ rankdir: direction, ...ROOM[direction], marginx: 2, marginy })
  for (const name of zonesOf(plant)) graph.setNode(zoneNode(name), {})
  for (const { name, zone } of plant.volumes) {
    graph.setNode(volumeNode(name), { ...VOLUME })
    if (zone !== null) graph.setParent(volumeNode(name), zoneNode(zone))
  }
  for (const part of plant.parts) {
    graph.setNode(partNode(part.name), { ...PART[direction] })
    const zone = zoneBetween(plant, part)
    if (zone !== null) graph.setParent(partNode(part.name), zoneNode(zone))
    linesOf(part).forEach(({ from, to }, index) => void graph.setEdge(from, to, {}, `${part.name} ${index}`))
  }
  layout(graph)
  const box = (id: string): Box => {
    const { x = 0, y = 0, width = 0, height = 0 } = graph.node(id) as Partial<Box>
    return { x, y, width, height }
  }
  const symbolOf = (part: PlantPart): Point => {
    const { x, y } = box(partNode(part.name))
    return { x: x + SYMBOL_X[direction], y }
  }
  const ids = [...plant.volumes.map(({ name }) => volumeNode(name)), ...plant.parts.map(({ name }) => partNode(name))]
  const { width = 0, height = 0 } = graph.graph() as { width?: number; height?: number }
  return {
    direction,
    width: Math.ceil(width),
    height: Math.ceil(height),
    boxes: new Map(ids.map((id) => [id, box(id)])),
    symbols: new Map(plant.parts.map((part) => [part.name, symbolOf(part)])),
    zones: zonesOf(plant).map((name) => {
      const volumes = plant.volumes.filter(({ zone }) => zone === name).map(({ name }) => box(volumeNode(name)))
      return { name, box: withName(box(zoneNode(name)), volumes) }
    }),
    lines: plant.parts.flatMap((part) =>
      linesOf(part).map(({ from, to }, index) => {
        const { points = [] } = graph.edge(from, to, `${part.name} ${index}`) as { points?: Point[] }
        const begins = from === partNode(part.name)
        const volume = box(begins ? to : from)
        const fromPart = toSymbol(begins ? points : [...points].reverse(), volume, SYMBOL_X[direction])
        const all = [symbolOf(part), ...fromPart]
        return { part: part.name, points: begins ? all : all.reverse() }
      }),
    ),
  }
}

/** The zone of the two volumes that a part is between; `null` if they are in different ones. */
function zoneBetween({ volumes }: PlantPicture, part: PlantPart): string | null {
  const [first, second] = part.volumes.map((name) => volumes.find((volume) => volume.name === name)?.zone ?? null)
  return first === second ? (first ?? null) : null
}

/** The frame of a zone, with room for its name above the volumes. */
function withName(zone: Box, volumes: Box[]): Box {
  const bottom = zone.y + zone.height / 2
  const top = Math.min(zone.y - zone.height / 2, ...volumes.map(({ y, height }) => y - height / 2 - ZONE_NAME))
  return { ...zone, y: (top + bottom) / 2, height: bottom - top }
}

/** The corner of a volume is round. */
const CORNER = 14

/** The points of a line from a part to a volume, moved to where the symbol is: a short line stays straight. */
function toSymbol(points: Point[], volume: Box, shift: number): Point[] {
  const [first, ...others] = points.map(({ x, y }) => ({ x, y }))
  if (first === undefined || shift === 0) return points
  first.x += shift
  // A longer line goes around volumes and stays where it is.
  if (others.length > 2) return [first, ...others]
  const [left, right] = [volume.x - volume.width / 2 + CORNER, volume.x + volume.width / 2 - CORNER]
  const end = Math.min(right, Math.max(left, first.x))
  return [first, ...others.map(({ y }, index) => ({ x: index === others.length - 1 ? end : first.x, y }))]
}
