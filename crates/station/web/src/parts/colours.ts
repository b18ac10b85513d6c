// Colours of curves: told apart by people who see red and green alike, on both grounds.

const LIGHT = ['#0b63b6', '#c2410c', '#0f7a52', '#8b35c9', '#a16207', '#0e7490', '#be185d', '#4b5b76']
const DARK = ['#5aa9f5', '#f08a4b', '#4cc38a', '#c084f5', '#e2b341', '#3fc1d8', '#f472b0', '#9aabc8']

export function colour(place: number, dark: boolean): string {
  const colours = dark ? DARK : LIGHT
  return colours[place % colours.length]!
}

/** A colour for each name, its own as long as nobody before it has the same. */
export function colours(names: string[], chosen: string[], dark: boolean): Map<string, string> {
  const taken = new Set<number>()
  const made = new Map(names.map((name, place) => [name, colour(place, dark)]))
  for (const name of names.filter((name) => chosen.includes(name))) {
    let place = names.indexOf(name) % LIGHT.length
    while (taken.has(place) && taken.size < LIGHT.length) place = (place + 1) % LIGHT.length
    taken.add(place)
    made.set(name, colour(place, dark))
  }
  return made
}

/** A colour of the page's own, by its name in CSS. */
export function own(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim()
}
