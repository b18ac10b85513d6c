// Finding parameters by any word of theirs.

import type { Block } from '../api.ts'

/** Blocks with those parameters in which every word occurs somewhere; blocks without any are left out. */
export function matching(blocks: Block[], wanted: string): Block[] {
  const words = wanted.toLowerCase().split(/\s+/).filter(Boolean)
  return blocks
    .map(({ name, parameters }) => ({
      name,
      parameters: parameters.filter(({ write: _, ...shown }) => {
        const text = [name, ...Object.values(shown)].join(' ').toLowerCase()
        return words.every((word) => text.includes(word))
      }),
    }))
    .filter(({ parameters }) => parameters.length > 0)
}
