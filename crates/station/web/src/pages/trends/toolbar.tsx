// The controls of the time that the trends page shows.

import './toolbar.css'
import type { JSX } from 'preact'
import { useEffect, useState } from 'preact/hooks'
import { MomentField } from '../../components/fields.tsx'
import { moment, momentOf } from '../../lib/format.ts'
import { isLive, moved, type Range, SHORTEST_MS, SPANS, toggled, windowOf, zoomed } from '../../lib/range.ts'
import { useLive } from '../../live.ts'
import { t } from '../../texts/texts.ts'
import type { TrendChoice } from './choice.ts'

interface ToolbarProps {
  choice: TrendChoice
  change: (change: Partial<TrendChoice>) => void
}

export function Toolbar({ choice: { range, isAllDecades }, change }: ToolbarProps): JSX.Element {
  const { now } = useLive()
  const window = windowOf(range, now)
  const middle = (window[0] + window[1]) / 2
  const steps: [symbol: string, label: string, range: () => Range][] = [
    ['‹', t.trends.earlier, () => moved(window, -0.5)],
    ['+', t.trends.zoomIn, () => zoomed(window, middle, 0.5)],
    ['−', t.trends.zoomOut, () => zoomed(window, middle, 2)],
    ['›', t.trends.later, () => moved(window, 0.5)],
  ]
  return (
    <div class="bar" role="toolbar" aria-label={t.trends.time}>
      <button
        type="button"
        class="live"
        title={isLive(range) ? t.trends.liveTitle : t.trends.heldTitle}
        onClick={() => change({ range: toggled(range, now) })}
      >
        <span aria-hidden="true">{isLive(range) ? '▶ ' : '❚❚ '}</span>
        {isLive(range) ? t.trends.live : t.trends.held}
      </button>
      <div class="buttons">
        {SPANS.map(({ name, ms }) => (
          <button
            type="button"
            key={name}
            aria-pressed={isLive(range) && range.last === ms}
            onClick={() => change({ range: { last: ms } })}
          >
            {t.trends.spans[name]}
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
        title={t.trends.allDecadesTitle}
      >
        {t.trends.allDecades}
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
    <form class="custom-window" onSubmit={apply} aria-label={t.trends.window(moment(window[0]), moment(window[1]))}>
      <MomentField label={t.trends.from} value={shownFrom} onInput={(text) => setEdited([text, shownTo])} />
      <span aria-hidden="true">–</span>
      <MomentField label={t.trends.to} value={shownTo} onInput={(text) => setEdited([shownFrom, text])} />
      <button type="submit" disabled={edited === null}>
        {t.trends.show}
      </button>
    </form>
  )
}
