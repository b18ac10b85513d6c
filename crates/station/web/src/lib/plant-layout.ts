// Places the plant with dagre. This module is loaded with the first picture, because the library is as large as the rest of the page.

import { Graph, layout } from '@dagrejs/dagre'
import type { PlantPicture } from '../api/types.ts'
import { linesOf, partNode, volumeNode, zonesOf } from './picture.ts'

export interface Box {
  /** The centre. */
  x: number
  y: number
  width: number
  height: number
}

export interface Layout {
  direction: Direction
  width: number
  height: number
  boxes: Map<string, Box>
  zones: { name: string; box: Box }[]
  lines: { part: string; points: { x: number; y: number }[] }[]
}

/** The size of a volume: the longest pressure fits in, `< 3.75 × 10⁻² micron`. */
const VOLUME = { width: 216, height: 92 }

/** The size of a part, whose symbol is at the centre; its words stand below it, beside a line that goes down. */
const PART = { LR: { width: 96, height: 96 }, TB: { width: 190, height: 50 } }

export type Direction = keyof typeof PART

const zoneNode = (name: string): string => `zone ${name}`

/** From left to right, or from top to bottom on a narrow page. */
export function laidOut(plant: PlantPicture, direction: Direction): Layout {
  const graph = new Graph({ compound: true, multigraph: true })
  graph.setGraph({ rankdir: direction, nodesep: 22, ranksep: 28, marginx: 8, marginy: 8 })
  for (const name of zonesOf(plant)) graph.setNode(zoneNode(name), {})
  for (const { name, zone } of plant.volumes) {
    graph.setNode(volumeNode(name), { ...VOLUME })
    if (zone !== null) graph.setParent(volumeNode(name), zoneNode(zone))
  }
  for (const part of plant.parts) {
    graph.setNode(partNode(part.name), { ...PART[direction] })
    linesOf(part).forEach(({ from, to }, index) => void graph.setEdge(from, to, {}, `${part.name} ${index}`))
  }
  layout(graph)
  const box = (id: string): Box => {
    const { x = 0, y = 0, width = 0, height = 0 } = graph.node(id) as Partial<Box>
    return { x, y, width, height }
  }
  const ids = [...plant.volumes.map(({ name }) => volumeNode(name)), ...plant.parts.map(({ name }) => partNode(name))]
  const { width = 0, height = 0 } = graph.graph() as { width?: number; height?: number }
  return {
    direction,
    width: Math.ceil(width),
    height: Math.ceil(height),
    boxes: new Map(ids.map((id) => [id, box(id)])),
    zones: zonesOf(plant).map((name) => ({ name, box: box(zoneNode(name)) })),
    lines: plant.parts.flatMap((part) =>
      linesOf(part).map(({ from, to }, index) => {
        const { points = [] } = graph.edge(from, to, `${part.name} ${index}`) as { points?: { x: number; y: number }[] }
        // A line ends at the edge of a box, and the symbol of a part is at the centre of its box.
        const symbol = box(partNode(part.name))
        return { part: part.name, points: from === partNode(part.name) ? [symbol, ...points] : [...points, symbol] }
      }),
    ),
  }
}
