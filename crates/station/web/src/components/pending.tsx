// Actions that the station has not answered yet: the pressed button and a line of the page say so.

import './pending.css'
import type { JSX } from 'preact'
import { actions } from '../api/request.ts'
import { createStore, useStore } from '../store.ts'
import { t } from '../texts/texts.ts'

/** An answer that comes sooner needs no words. */
const SOON_MS = 400

/** How many actions have waited for longer than that. */
const waiting = createStore(0)

/** The button that is being pressed, until the end of its event. */
let pressed: Element | null = null

/** Begins to show waiting actions. Presses are noticed before the page handles them. */
export function showWaitingActions(): void {
  const press = (button: Element | null | undefined): void => {
    pressed = button ?? null
    setTimeout(() => {
      pressed = null
    })
  }
  actions.begin = actionWaits
  addEventListener('click', ({ target }) => press(target instanceof Element ? target.closest('button') : null), true)
  addEventListener('submit', (event) => press((event as SubmitEvent).submitter), true)
}

/** Shows that an action waits, from a little later on until the returned function is called. */
function actionWaits(): () => void {
  const button = pressed
  let isShown = false
  const timer = setTimeout(() => {
    isShown = true
    button?.setAttribute('aria-busy', 'true')
    waiting.set(waiting.get() + 1)
  }, SOON_MS)
  return () => {
    clearTimeout(timer)
    if (!isShown) return
    button?.removeAttribute('aria-busy')
    waiting.set(waiting.get() - 1)
  }
}

/** In all pages: whether an action waits. */
export function WaitingActions(): JSX.Element {
  return (
    <p class="waiting-actions" role="status">
      {useStore(waiting) > 0 && t.app.actionWaits}
    </p>
  )
}
