/** A number with its noun: `1 alarm`, `2 alarms`. */
export const counted = (count: number, one: string, several: string): string =>
  `${count} ${count === 1 ? one : several}`
