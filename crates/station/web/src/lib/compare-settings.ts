// The settings of two gauges of the same model, compared.

import type { Block, Parameter } from '../api/types.ts'
import { isUnit, UNITS } from './units.ts'

export interface Difference {
  /** The parameter of this gauge, with its value. */
  parameter: Parameter
  /** The value of the other gauge. */
  other: string
}

export interface Comparison {
  /** The settings that both gauges have given. */
  compared: number
  /** Those that differ, in the order of the manual. */
  differences: Difference[]
}

/** Compares what can be written; a parameter that one of the gauges has not given is left out. */
export function compared(own: Block[], other: Block[]): Comparison {
  const others = new Map(parametersOf(other).map(({ target, value }) => [target, value]))
  const both = parametersOf(own).flatMap((parameter) => {
    const value = others.get(parameter.target) ?? null
    return parameter.write === null || parameter.value === null || value === null ? [] : [{ parameter, other: value }]
  })
  return { compared: both.length, differences: both.filter(({ parameter, other }) => !isSame(parameter.value, other)) }
}

const parametersOf = (blocks: Block[]): Parameter[] => blocks.flatMap(({ parameters }) => parameters)

/** The same text, or the same pressure in two units. chosen: a millionth, which the 32 bits of a gauge do not distinguish. */
function isSame(one: string | null, other: string): boolean {
  if (one === other) return true
  const [first, second] = [pascals(one ?? ''), pascals(other)]
  return first !== null && second !== null && Math.abs(first - second) <= 1e-6 * Math.abs(first)
}

/** `1e-3 mbar` in Pa; `null` if it is no pressure. */
function pascals(text: string): number | null {
  const [value = '', unit = ''] = text.split(' ')
  return isUnit(unit) && value !== '' && Number.isFinite(Number(value)) ? Number(value) * UNITS[unit] : null
}
