// The search for parameters.

import type { Block } from '../api/types.ts'

/** The parameters in which every word of `text` occurs, in their blocks; blocks without such parameters are left out. */
export function matchingBlocks(blocks: Block[], text: string): Block[] {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean)
  return blocks
    .map(({ name, parameters }) => ({
      name,
      parameters: parameters.filter(({ write: _, ...shown }) => {
        const searched = [name, ...Object.values(shown)].join(' ').toLowerCase()
        return words.every((word) => searched.includes(word))
      }),
    }))
    .filter(({ parameters }) => parameters.length > 0)
}
