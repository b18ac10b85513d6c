// The live data of all stations: one stream of server-sent events for all pages.

import { changed } from '../lib/changes.ts'
import type { FromHub } from '../lib/stream-hub.ts'
import { canView, onSessionChange, refreshSession, sessionToken } from '../session.ts'
import { sharedStream } from '../shared-stream.ts'
import { createStore, useStore } from '../store.ts'
import type { State } from './types.ts'

/** Without an event for this long the archive counts as lost: it sends one a second. */
const SILENCE_MS = 6_000
const TICK_MS = 1_000

export interface Live {
  /** The last state that was received; `null` before the first. */
  state: State | null
  connected: boolean
  /** The clock of the archive. */
  now: number
}

let state: State | null = null
let receivedAt = performance.now()
/** Changes with every event, and every tick without one. */
const changes = createStore(0)

export function live(): Live {
  const since = performance.now() - receivedAt
  return {
    state,
    connected: state !== null && since < SILENCE_MS,
    now: state ? Math.round(state.now_ms + since) : Date.now(),
  }
}

/** The parts of the state whose entries a change names. */
const BY_NAME = ['stations', 'readings', 'alarms'] as const

/** Receives live data while the session allows it. */
export function startLive(): void {
  const stream = sharedStream({ silenceMs: 2 * SILENCE_MS, byName: [...BY_NAME] }, hear)
  const follow = (): void => {
    if (canView()) stream.join(sessionToken())
    else {
      stream.leave()
      forget()
    }
  }
  onSessionChange(follow)
  follow()
  setInterval(() => {
    if (performance.now() - receivedAt > TICK_MS) notify()
  }, TICK_MS)
}

function hear(message: FromHub): void {
  if (message.kind === 'ended') void refreshSession()
  else if (message.kind === 'snapshot') receive(JSON.parse(message.data) as State, message.ageMs)
  else if (state) receive(changed(state, JSON.parse(message.data) as Partial<State>, [...BY_NAME]))
}

/** Forgets the data: the next user may be another one. */
function forget(): void {
  if (!state) return
  state = null
  notify()
}

/** `ageMs`: how long ago another window received it. */
function receive(received: State, ageMs = 0): void {
  state = received
  receivedAt = performance.now() - ageMs
  notify()
}

function notify(): void {
  changes.set(changes.get() + 1)
}

/** Live data; the component is drawn again with every change. */
export function useLive(): Live {
  useStore(changes)
  return live()
}

/** The last state. Only for pages: they are drawn after the first state has been received. */
export function useArchive(): State {
  const { state } = useLive()
  if (!state) throw new Error('expected a state, got none: pages are drawn after the first one')
  return state
}
