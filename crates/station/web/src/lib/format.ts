// Numbers, times and ages as text.

import { t } from '../texts/texts.ts'

const SUPERSCRIPTS = '⁰¹²³⁴⁵⁶⁷⁸⁹'
const MINUS = '⁻'

/** A number as mantissa and power of ten; the exponent is `null` where the number is short without one. */
export interface Parts {
  mantissa: string
  exponent: number | null
}

/** From 1 to below 10000 without a power of ten. Three digits, or all digits before the point. */
export function parts(value: number): Parts {
  if (value === 0) return { mantissa: '0', exponent: null }
  const size = Math.abs(value)
  if (size >= 0.9995 && size < 9999.5) {
    const digits = size >= 99.95 ? 0 : size >= 9.995 ? 1 : 2
    return { mantissa: value.toFixed(digits), exponent: null }
  }
  const [mantissa = '', exponent = '0'] = value.toExponential(2).split('e')
  return { mantissa, exponent: Number(exponent) }
}

export function superscript(exponent: number): string {
  const digits = [...String(Math.abs(exponent))].map((digit) => SUPERSCRIPTS[Number(digit)]).join('')
  return exponent < 0 ? MINUS + digits : digits
}

/** `1.23 × 10⁻⁶`, `1013`. */
export function number(value: number): string {
  const { mantissa, exponent } = parts(value)
  return exponent === null ? mantissa : `${mantissa} × 10${superscript(exponent)}`
}

/** A ratio or an exponent: `0.925`, `3.61`. Below a thousandth as a power of ten. */
export function ratio(value: number): string {
  const size = Math.abs(value)
  return size >= 0.001 && size < 0.9995 ? String(Number(value.toPrecision(3))) : number(value)
}

/** A power of ten for an axis: `10⁻⁶`, or the plain number from 1 to 1000. */
export function decade(value: number): string {
  const exponent = Math.round(Math.log10(value))
  return exponent >= 0 && exponent <= 3 ? String(10 ** exponent) : `10${superscript(exponent)}`
}

/** A number with its unit, which no line breaks. */
export const unbroken = (text: string): string => text.replaceAll(' ', '\u00a0')

/** A day with its time, or a number with its unit. */
const QUANTITY =
  /(\d{4}-\d\d-\d\d \d\d:\d\d(?::\d\d)?|(?:[<>±] ?)?\d[\d.]*(?:e[+-]?\d+|\s×\s10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?\s?(?:%|(?:mbar|hPa|Pa|Torr|micron|decades|Dekaden|[kM]bit|ms|min|s|h|d)(?:\/(?:min|s))?(?![\p{L}\d])))/u

/** A text in parts: those with an odd index are quantities, which no line may break. */
export const quantities = (text: string): string[] => text.split(QUANTITY)

const STEPS: [number, string][] = [
  [86_400, 'd'],
  [3_600, 'h'],
  [60, 'min'],
]

/** A duration in its two largest units: `3.1 s`, `42 s`, `3 min 5 s`, `2 d 4 h`. */
export function age(ms: number): string {
  const seconds = ms / 1000
  if (seconds < 1) return t.common.lessThan1s
  if (seconds < 9.95) return `${seconds.toFixed(1)} s`
  let rest = Math.round(seconds)
  if (rest < 60) return `${rest} s`
  const words: string[] = []
  for (const [length, name] of [...STEPS, [1, 's'] as [number, string]]) {
    const count = Math.floor(rest / length)
    rest -= count * length
    if (count > 0) words.push(`${count} ${name}`)
    else if (words.length > 0) break
    if (words.length === 2) break
  }
  return words.join(' ')
}

const two = (value: number): string => String(value).padStart(2, '0')

/** `14:03:22` in the time zone of the browser. */
export function clock(ms: number): string {
  const at = new Date(ms)
  return `${two(at.getHours())}:${two(at.getMinutes())}:${two(at.getSeconds())}`
}

/** `2026-01-31`. */
export function day(ms: number): string {
  const at = new Date(ms)
  return `${at.getFullYear()}-${two(at.getMonth() + 1)}-${two(at.getDate())}`
}

export function moment(ms: number): string {
  return `${day(ms)} ${clock(ms)}`
}

/** The time that `2026-01-31 14:03:22` names in the time zone of the browser; `null` if the text has another form. Seconds may be left out. */
export function momentOf(text: string): number | null {
  const found = /^(\d{4}-\d\d-\d\d)[ T](\d\d:\d\d)(:\d\d)?$/.exec(text.trim())
  const ms = found ? Date.parse(`${found[1]}T${found[2]}${found[3] ?? ':00'}`) : Number.NaN
  return Number.isFinite(ms) ? ms : null
}

/** A count with groups of three digits. A point and a comma are both read as a decimal mark: the mark between groups is a space (ISO 80000-1). */
export const grouped = (value: number): string => value.toLocaleString('en-GB').replaceAll(',', '\u202f')

/** A size of a file: `3.10 kB`, `24.0 MB`. */
export function fileSize(octets: number): string {
  const sizes: [number, string][] = [
    [1e9, 'GB'],
    [1e6, 'MB'],
    [1e3, 'kB'],
  ]
  const [size, name] = sizes.find(([size]) => octets >= size) ?? [1, 'B']
  return unbroken(`${parts(octets / size).mantissa} ${name}`)
}

/** A time in UTC: `2026-01-31T14:03:22Z`, or `2026-01-31 14:03:22 UTC` in a sentence. */
const UTC = /\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(?:\.\d+)?(?:Z| UTC)/
const NUMBER = /\d+(\.\d+)?e[+-]?\d+/
const READ = new RegExp(`"[^"]*"|${UTC.source}|${NUMBER.source}`, 'g')
const TIMES = new RegExp(`"[^"]*"|${UTC.source}`, 'g')

/**
 * A text of the station for reading: long numbers are rounded, `4.5095703e-8 mbar` becomes `4.51 × 10⁻⁸ mbar`, and times are those of the time
 * zone of the browser. Names in quotation marks stay.
 */
export function readable(text: string): string {
  return text.replace(READ, (found) => {
    if (found.startsWith('"')) return found
    return UTC.test(found) ? localTime(found) : number(Number(found))
  })
}

/** A text of the station with the times of the time zone of the browser. Its numbers and the names in quotation marks stay as they were recorded. */
export const withLocalTimes = (text: string): string =>
  text.replace(TIMES, (found) => (found.startsWith('"') ? found : localTime(found)))

const localTime = (utc: string): string => moment(Date.parse(utc.replace(' UTC', 'Z').replace(' ', 'T')))
