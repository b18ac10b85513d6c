// Keys and marks, over everything.

import type { JSX } from 'preact'
import { useEffect, useRef } from 'preact/hooks'
import { PAGES } from './app.tsx'
import { STANDINGS } from './pure/words.ts'
import { StandingMark } from './parts/standing.tsx'
import type { Standing } from './api.ts'

const KEYS = [
  ['u', 'next unit'],
  ['t', 'colours: as the system has them, light, dark'],
  ['Tab', 'to the next thing that can be pressed'],
  ['← →', 'earlier and later, in a chart'],
  ['+ −', 'closer and farther, in a chart'],
  ['Home', 'back to what happens now, in a chart'],
  ['?', 'this'],
] as const

export function Help({ close }: { close: () => void }): JSX.Element {
  const dialog = useRef<HTMLDialogElement>(null)
  useEffect(() => dialog.current?.showModal(), [])
  return (
    <dialog ref={dialog} onClose={close} aria-label="Keys and marks">
      <h2>Keys</h2>
      <dl class="keys">
        {[...PAGES.map(({ key, name }) => [key, name] as const), ...KEYS].map(([key, words]) => (
          <div key={key}>
            <dt>
              <kbd>{key}</kbd>
            </dt>
            <dd>{words}</dd>
          </div>
        ))}
      </dl>
      <h2>Marks</h2>
      <dl class="keys marks">
        {(Object.keys(STANDINGS) as Standing[]).map((standing) => (
          <div key={standing}>
            <dt>
              <StandingMark standing={standing} />
            </dt>
            <dd>{STANDINGS[standing].sentence}</dd>
          </div>
        ))}
      </dl>
      <button type="button" class="main" onClick={close}>
        Close
      </button>
    </dialog>
  )
}
