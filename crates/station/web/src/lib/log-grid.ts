// The grid of a logarithmic axis: the numbers 2 to 9 of each decade, of which 2 and 5 have names where there is room.

const DIGITS = [2, 3, 4, 5, 6, 7, 8, 9]

/** Lines that are closer make the plot grey. chosen: the last two of a decade are then a pixel apart. */
const LEAST_DECADE_PX = 24

/** The part of a decade from 1 to 2, and from 5 to 10: the smallest one between two names. */
const CLOSEST = Math.log10(2)

/** The numbers that have lines within a decade of this length in pixels. */
export const minorDigits = (decadePx: number): number[] => (decadePx < LEAST_DECADE_PX ? [] : DIGITS)

/** Whether 2 and 5 have names in a decade of this length, each of which needs so many pixels. */
export const areNamed = (decadePx: number, namePx: number): boolean => decadePx * CLOSEST >= namePx

export const isNamed = (digit: number): boolean => digit === 2 || digit === 5

/** The powers of ten of an axis from one power to another, as many as have room for a name, and 2 and 5 of each decade if they have room too. */
export function namedValues(low: number, high: number, lengthPx: number, namePx: number): number[] {
  const [from, to] = [Math.round(Math.log10(low)), Math.round(Math.log10(high))]
  const step = Math.max(1, Math.ceil(((to - from) * namePx) / lengthPx))
  const hasDigits = to > from && areNamed(lengthPx / (to - from), namePx)
  const made: number[] = []
  for (let exponent = from; exponent <= to; exponent += step) {
    made.push(10 ** exponent)
    if (hasDigits && exponent < to) made.push(2 * 10 ** exponent, 5 * 10 ** exponent)
  }
  return made
}

/** The values of the lines between the powers of ten. */
export function minorValues(low: number, high: number, lengthPx: number): number[] {
  const [from, to] = [Math.round(Math.log10(low)), Math.round(Math.log10(high))]
  const digits = to > from ? minorDigits(lengthPx / (to - from)) : []
  return Array.from({ length: Math.max(0, to - from) }, (_, step) => 10 ** (from + step)).flatMap((power) =>
    digits.map((digit) => digit * power),
  )
}

/** The digit of a value that is no power of ten, `null` for a power. */
export function digitOf(value: number): number | null {
  const digit = Math.round(value / 10 ** Math.floor(Math.log10(value) + 1e-9))
  return digit === 1 || digit === 10 ? null : digit
}
