// Colours and names of curves.

/**
 * Users who do not distinguish red and green can tell these apart, on light and on dark ground. None is close to the colour of an
 * alarm.
 */
export const CURVE_COLOURS = {
  light: ['#0b63b6', '#0f7a52', '#4b5b76', '#9c5a86', '#5c7a00', '#16202e', '#7d5f4c', '#0b4a3f'],
  dark: ['#5aa9f5', '#4cc38a', '#9aabc8', '#3fc1d8', '#b5d334', '#ffffff', '#c9a893', '#a9f0dc'],
}

export function curveColour(index: number, dark: boolean): string {
  const colours = dark ? CURVE_COLOURS.dark : CURVE_COLOURS.light
  return colours[index % colours.length] ?? 'gray'
}

/** A colour for each name. Chosen names have different colours while there are enough. */
export function curveColours(names: string[], chosen: string[], dark: boolean): Map<string, string> {
  const count = CURVE_COLOURS.light.length
  const taken = new Set<number>()
  const colours = new Map(names.map((name, index) => [name, curveColour(index, dark)]))
  for (const name of names.filter((name) => chosen.includes(name))) {
    let index = names.indexOf(name) % count
    while (taken.has(index) && taken.size < count) index = (index + 1) % count
    taken.add(index)
    colours.set(name, curveColour(index, dark))
  }
  return colours
}
