// Where the names of horizontal lines stand in a chart, in CSS pixels from the corner of its plot area.

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
