// One stream of server-sent events for all windows of a browser. A browser opens six connections to a station without TLS: if each window
// held one, the seventh could neither load nor acknowledge.

import { changed } from './changes.ts'

/** What a window tells the hub. */
export type ToHub = { kind: 'join'; session: string; options: StreamOptions } | { kind: 'leave' }

/** What the hub tells its windows. */
export type FromHub =
  /** The whole state as JSON, and how long ago it was received. */
  | { kind: 'snapshot'; data: string; ageMs: number }
  | { kind: 'change'; data: string }
  /** The stream has ended or belongs to another session: the session of the window may have ended too. */
  | { kind: 'ended' }

export interface StreamOptions {
  /** Without an event for this long the stream is opened again. */
  silenceMs: number
  /** The parts of the state whose entries a change names. */
  byName: string[]
}

export type Member = (message: FromHub) => void

/** The part of an `EventSource` that the hub uses. */
export interface Source {
  readonly readyState: number
  close: () => void
  addEventListener: (name: string, listener: (event: MessageEvent<string>) => void) => void
}

export interface Hub {
  /** Adds a window of this session. It is told the state at once if the hub has one. */
  join: (member: Member, session: string) => void
  /** The last window that leaves ends the stream. */
  leave: (member: Member) => void
  /** Opens the stream again if it has failed or is silent. The browser reconnects by itself, except after an HTTP error and on a silent connection. */
  check: () => void
}

/** The hub's owner calls `check` this often. */
export const CHECK_MS = 500

/** `EventSource.CLOSED`. */
const CLOSED = 2

export function createHub({ silenceMs, byName }: StreamOptions, open: () => Source, now: () => number): Hub {
  const members = new Set<Member>()
  let session = ''
  let source: Source | null = null
  let state: Record<string, unknown> | null = null
  let receivedAt = 0
  /** When something was last received, or the stream opened. */
  let heardAt = 0

  const tell = (message: FromHub): void => {
    for (const member of members) member(message)
  }
  const receive = (next: Record<string, unknown>): void => {
    state = next
    receivedAt = now()
    heardAt = receivedAt
  }
  const connect = (): void => {
    source?.close()
    heardAt = now()
    const opened = open()
    source = opened
    // Each connection begins with the whole state, also when the browser connects again by itself.
    opened.addEventListener('snapshot', ({ data }) => {
      if (opened !== source) return
      receive(JSON.parse(data) as Record<string, unknown>)
      tell({ kind: 'snapshot', data, ageMs: 0 })
    })
    opened.addEventListener('change', ({ data }) => {
      if (opened !== source || !state) return
      receive(changed(state, JSON.parse(data) as Record<string, unknown>, byName))
      tell({ kind: 'change', data })
    })
    opened.addEventListener('error', () => {
      if (opened === source) tell({ kind: 'ended' })
    })
  }

  return {
    join: (member, by) => {
      const isOther = by !== session
      session = by
      if (source && !isOther) {
        members.add(member)
        if (state) member({ kind: 'snapshot', data: JSON.stringify(state), ageMs: now() - receivedAt })
        return
      }
      // What another session has received is not shown; its windows ask which session the browser has now.
      state = null
      members.delete(member)
      tell({ kind: 'ended' })
      members.add(member)
      connect()
    },
    leave: (member) => {
      members.delete(member)
      if (members.size > 0) return
      source?.close()
      source = null
      state = null
    },
    check: () => {
      if (!source || (source.readyState !== CLOSED && now() - heardAt <= silenceMs)) return
      connect()
      tell({ kind: 'ended' })
    },
  }
}
