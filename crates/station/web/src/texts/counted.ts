/** A number with its noun: `1 alarm`, `2 alarms`. */
export const counted = (count: number, one: string, several: string): string =>
  `${count} ${count === 1 ? one : several}`

/** The texts that are not empty, with a separator between them. */
export const joined = (texts: string[], separator: string): string => texts.filter(Boolean).join(separator)
