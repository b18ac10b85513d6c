// The value of a point in words.

import type { Point } from '../api/types.ts'

/** The value with its unit, or why the number is bad; `null` without a value, and for one that is too old. */
export function pointText({ text, quality }: Point, isStale: boolean): string | null {
  return isStale || quality === 'stale' ? null : text
}
