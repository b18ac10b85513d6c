// The controls of the time that the trends page shows.

import './toolbar.css'
import type { JSX } from 'preact'
import { useEffect, useState } from 'preact/hooks'
import { MomentField } from '../../components/fields.tsx'
import { moment, momentOf } from '../../lib/format.ts'
import { isLive, moved, type Range, SHORTEST_MS, SPANS, windowOf, zoomed } from '../../lib/range.ts'
import { useLive } from '../../live.ts'
import type { TrendChoice } from './choice.ts'

interface ToolbarProps {
  choice: TrendChoice
  change: (change: Partial<TrendChoice>) => void
}

export function Toolbar({ choice: { range, isAllDecades }, change }: ToolbarProps): JSX.Element {
  const window = windowOf(range, useLive().now)
  const middle = (window[0] + window[1]) / 2
  const steps: [symbol: string, label: string, range: () => Range][] = [
    ['‹', 'Earlier', () => moved(window, -0.5)],
    ['+', 'Zoom in', () => zoomed(window, middle, 0.5)],
    ['−', 'Zoom out', () => zoomed(window, middle, 2)],
    ['›', 'Later', () => moved(window, 0.5)],
  ]
  return (
    <div class="bar" role="toolbar" aria-label="Time">
      <div class="buttons">
        {SPANS.map(({ name, label, ms }) => (
          <button
            type="button"
            key={name}
            aria-pressed={isLive(range) && range.last === ms}
            onClick={() => change({ range: { last: ms } })}
          >
            {label}
          </button>
        ))}
      </div>
      <div class="buttons">
        {steps.map(([symbol, label, range]) => (
          <button type="button" aria-label={label} key={label} onClick={() => change({ range: range() })}>
            {symbol}
          </button>
        ))}
      </div>
      <button
        type="button"
        aria-pressed={isAllDecades}
        onClick={() => change({ isAllDecades: !isAllDecades })}
        title="Show all decades, or only those of the values"
      >
        All decades
      </button>
    </div>
  )
}

interface CustomWindowProps {
  window: [number, number]
  /** Whether the window moves with the time. */
  live: boolean
  setRange: (range: Range) => void
}

/** Fields for start and end. In a live range they follow the window once a second. */
export function CustomWindow({ window, live, setRange }: CustomWindowProps): JSX.Element {
  const [from, to] = window.map(moment) as [string, string]
  const [edited, setEdited] = useState<[string, string] | null>(null)
  useEffect(() => setEdited(null), [live ? 0 : from, live ? 0 : to])
  const [shownFrom, shownTo] = edited ?? [from, to]
  const apply = (event: Event): void => {
    event.preventDefault()
    const [start, end] = [momentOf(shownFrom), momentOf(shownTo)]
    if (start !== null && end !== null && end - start >= SHORTEST_MS) setRange({ from: start, to: end })
  }
  return (
    <form class="custom-window" onSubmit={apply} aria-label={`From ${moment(window[0])} to ${moment(window[1])}`}>
      <MomentField label="From" value={shownFrom} onInput={(text) => setEdited([text, shownTo])} />
      <span aria-hidden="true">–</span>
      <MomentField label="To" value={shownTo} onInput={(text) => setEdited([shownFrom, text])} />
      <button type="submit" disabled={edited === null}>
        Show
      </button>
    </form>
  )
}
