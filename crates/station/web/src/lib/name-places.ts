// Where the names in a chart stand, in pixels from the upper left corner of its plot: a name over a curve or over another name could
// not be read.

export interface Rect {
  left: number
  top: number
  width: number
  height: number
}

/** The size of a name. */
export type Size = Pick<Rect, 'width' | 'height'>

/** What a curve covers: its top and bottom in each column of pixels, `null` where it has none. */
export type Profile = (readonly [top: number, bottom: number] | null)[]

/** The names that are there already, and the curves. */
export interface Obstacles {
  rects: Rect[]
  curves: Profile[]
}

/** Between a name and the curve or line to which it belongs. */
const GAP = 3

/** Between a name and any other curve: its line has a width. */
const CLEAR = 2

/** Between two places that are tried, along a row. */
const STEP = 24

/** The profile of a curve through points that rise in x; `null` breaks the curve. */
export function profileOf(points: (readonly [x: number, y: number] | null)[], width: number): Profile {
  const columns: [number, number][] = []
  let before: readonly [number, number] | null = null
  for (const point of points) {
    if (point) widen(columns, before ?? point, point, width)
    before = point
  }
  return Array.from({ length: width }, (_, column) => columns[column] ?? null)
}

/** Adds the columns of a straight piece. */
function widen(
  columns: [number, number][],
  [x, y]: readonly [number, number],
  to: readonly [number, number],
  width: number,
): void {
  const slope = to[0] > x ? (to[1] - y) / (to[0] - x) : 0
  for (let column = Math.max(0, Math.floor(x)); column <= Math.min(width - 1, Math.floor(to[0])); column += 1) {
    const ends =
      to[0] > x ? [Math.max(x, column), Math.min(to[0], column + 1)].map((at) => y + slope * (at - x)) : [y, to[1]]
    const all = [...ends, ...(columns[column] ?? [])]
    columns[column] = [Math.min(...all), Math.max(...all)]
  }
}

/** The top and bottom of a curve from one column to another; `null` where it has none. */
export function extent(curve: Profile, from: number, to: number): readonly [top: number, bottom: number] | null {
  let all: [number, number] | null = null
  for (const span of curve.slice(Math.max(0, Math.floor(from)), Math.max(0, Math.ceil(to)))) {
    if (span) all = all ? [Math.min(all[0], span[0]), Math.max(all[1], span[1])] : [...span]
  }
  return all
}

/** The left edges of a name in a row, from `from` on; towards the left if `isFromRight`. */
export function along(from: number, to: number, isFromRight = false): number[] {
  const count = to < from ? 0 : Math.floor((to - from) / STEP) + 1
  return Array.from({ length: count }, (_, index) => (isFromRight ? to - index * STEP : from + index * STEP))
}

/** The places of a name at a horizontal line: above it, then below it. */
export function placesAtLine(y: number, { width, height }: Size, plot: Size): Rect[] {
  return [y - GAP - height, y + GAP].flatMap((top) =>
    along(8, plot.width - width - 4).map((left) => ({ left, top, width, height })),
  )
}

/** A name above a steep piece of its curve that is higher than this would be far from the rest of it. */
const STEEP = 20

/** The places of a name at its curve, close to the end first, and beside flat pieces first: above the curve, or below it. */
export function placesAtCurve(curve: Profile, { width, height }: Size, plot: Size): Rect[] {
  let end = curve.length
  while (end > 0 && !curve[end - 1]) end -= 1
  const [flat, steep]: [Rect[], Rect[]] = [[], []]
  for (const left of along(0, Math.min(end, plot.width - 4) - width, true)) {
    const covered = extent(curve, left, left + width)
    if (!covered) continue
    const [top, bottom] = covered
    const list = bottom - top > STEEP ? steep : flat
    list.push(...[top - GAP - height, bottom + GAP].map((top) => ({ left, top, width, height })))
  }
  return [...flat, ...steep]
}

/** The first place within the plot that meets no name and no curve. `null` if there is none. */
export function firstFree(places: Rect[], { rects, curves }: Obstacles, plot: Size): Rect | null {
  const isFree = (place: Rect): boolean =>
    isInside(place, plot) &&
    !rects.some((other) => meet(place, other)) &&
    !curves.some((curve) => meetsCurve(place, curve))
  return places.find(isFree) ?? null
}

const isInside = ({ left, top, width, height }: Rect, plot: Size): boolean =>
  left >= 0 && top >= 0 && left + width <= plot.width && top + height <= plot.height

const meet = (one: Rect, other: Rect): boolean =>
  one.left < other.left + other.width &&
  other.left < one.left + one.width &&
  one.top < other.top + other.height &&
  other.top < one.top + one.height

function meetsCurve({ left, top, width, height }: Rect, curve: Profile): boolean {
  const columns = curve.slice(Math.max(0, Math.floor(left)), Math.max(0, Math.ceil(left + width)))
  return columns.some((span) => span !== null && span[1] > top - CLEAR && span[0] < top + height + CLEAR)
}
