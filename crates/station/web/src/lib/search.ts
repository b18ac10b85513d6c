// The search for gauges, series and parameters.

import type { Block } from '../api/types.ts'

/** Whether every word of `text` occurs in one of the texts. */
export function matchesWords(texts: string[], text: string): boolean {
  const searched = texts.join(' ').toLowerCase()
  return text
    .toLowerCase()
    .split(/\s+/)
    .every((word) => searched.includes(word))
}

/** The parameters in which every word of `text` occurs, in their blocks; blocks without such parameters are left out. */
export function matchingBlocks(blocks: Block[], text: string): Block[] {
  return blocks
    .map(({ name, parameters }) => ({
      name,
      parameters: parameters.filter(({ write: _, ...shown }) =>
        matchesWords([name, ...Object.values(shown).map((value) => value ?? '')], text),
      ),
    }))
    .filter(({ parameters }) => parameters.length > 0)
}
