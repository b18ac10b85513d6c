// Colours of curves. Users who do not distinguish red and green can tell them apart, on light and on dark ground. Those that are
// close to the colours of alarms come last.

const LIGHT = ['#0b63b6', '#0f7a52', '#4b5b76', '#0e7490', '#be185d', '#8b35c9', '#a16207', '#c2410c']
const DARK = ['#5aa9f5', '#4cc38a', '#9aabc8', '#3fc1d8', '#f472b0', '#c084f5', '#e2b341', '#f08a4b']

export function curveColour(index: number, dark: boolean): string {
  const colours = dark ? DARK : LIGHT
  return colours[index % colours.length] ?? 'gray'
}

/** A colour for each name. Chosen names have different colours while there are enough. */
export function curveColours(names: string[], chosen: string[], dark: boolean): Map<string, string> {
  const taken = new Set<number>()
  const colours = new Map(names.map((name, index) => [name, curveColour(index, dark)]))
  for (const name of names.filter((name) => chosen.includes(name))) {
    let index = names.indexOf(name) % LIGHT.length
    while (taken.has(index) && taken.size < LIGHT.length) index = (index + 1) % LIGHT.length
    taken.add(index)
    colours.set(name, curveColour(index, dark))
  }
  return colours
}

/** The present value of a colour in styles/tokens.css, for a canvas. */
export function tokenColour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim()
}
