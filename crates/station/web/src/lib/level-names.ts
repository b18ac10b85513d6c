// Where the names of horizontal lines and of bands stand in a chart, in pixels.

export interface NamedLine {
  /** The height of the line. */
  y: number
  /** The width of the name. */
  width: number
}

/** The height of a name, and the room between its line and its upper edge. */
const HEIGHT = 13
const ABOVE = 15

/** The room on the left of a name. */
const LEFT = 8

/** The upper left corner of each name: above its line, or below it at the upper edge; beside the names that are there already. */
export function namePlaces(lines: NamedLine[]): { x: number; y: number }[] {
  const placed: { x: number; y: number; right: number }[] = []
  for (const { y: line, width } of lines) {
    const y = line < ABOVE ? line + 3 : line - ABOVE
    const beside = placed.filter((one) => Math.abs(one.y - y) < HEIGHT).map(({ right }) => right)
    const x = Math.max(0, ...beside) + LEFT
    placed.push({ x, y, right: x + width })
  }
  return placed.map(({ x, y }) => ({ x, y }))
}

export interface Rect {
  left: number
  top: number
  width: number
  height: number
}

/** The first place that meets no name that is there already: of the first row first. `null` if there is none. */
export function freePlace(
  lefts: number[],
  tops: number[],
  size: { width: number; height: number },
  taken: Rect[],
): Rect | null {
  const all = tops.flatMap((top) => lefts.map((left) => ({ left, top, ...size })))
  return all.find((place) => !taken.some((other) => meet(place, other))) ?? null
}

const meet = (one: Rect, other: Rect): boolean =>
  one.left < other.left + other.width &&
  other.left < one.left + one.width &&
  one.top < other.top + other.height &&
  other.top < one.top + one.height
