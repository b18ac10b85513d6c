// A value that components follow: they are drawn again when it changes.

import { useEffect, useState } from 'preact/hooks'

export interface Store<T> {
  get: () => T
  set: (value: T) => void
  /** Calls `listener` after every change, until the returned function is called. */
  subscribe: (listener: () => void) => () => void
}

export function createStore<T>(initial: T): Store<T> {
  let value = initial
  const listeners = new Set<() => void>()
  return {
    get: () => value,
    set: (next) => {
      value = next
      for (const listener of listeners) listener()
    },
    subscribe: (listener) => {
      listeners.add(listener)
      return () => void listeners.delete(listener)
    },
  }
}

/** A part of the value of a store; the component is drawn again when that part changes. */
export function useStore<T, S = T>(
  { get, subscribe }: Store<T>,
  select: (value: T) => S = (value) => value as never,
): S {
  const [shown, setShown] = useState(() => select(get()))
  useEffect(() => {
    const changed = (): void => setShown(() => select(get()))
    // The value may have changed between the first drawing and this effect.
    changed()
    return subscribe(changed)
  }, [])
  return shown
}
