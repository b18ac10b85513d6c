// Things that take time: asked again when what is asked for changes, and now and then.

import { useEffect, useRef, useState } from 'preact/hooks'

export interface Asked<T> {
  value: T | null
  error: string | null
  busy: boolean
}

/** Asks whenever `key` changes and every `everyMs`; what was there before stays until the answer is. */
export function useAsked<T>(key: string, everyMs: number | null, ask: (signal: AbortSignal) => Promise<T>): Asked<T> {
  const [asked, setAsked] = useState<Asked<T>>({ value: null, error: null, busy: true })
  const latest = useRef(ask)
  latest.current = ask
  useEffect(() => {
    const stop = new AbortController()
    let timer: number | undefined
    const once = async (): Promise<void> => {
      setAsked((before) => ({ ...before, busy: true }))
      try {
        const value = await latest.current(stop.signal)
        if (!stop.signal.aborted) setAsked({ value, error: null, busy: false })
      } catch (error) {
        if (!stop.signal.aborted) setAsked((before) => ({ ...before, error: sentence(error), busy: false }))
      }
      if (!stop.signal.aborted && everyMs !== null) timer = window.setTimeout(once, everyMs)
    }
    void once()
    return () => {
      stop.abort()
      clearTimeout(timer)
    }
  }, [key, everyMs])
  return asked
}

export function sentence(error: unknown): string {
  return error instanceof Error ? error.message : String(error)
}

/** The width of an element in pixels, 0 before it is known. */
export function useWidth(): [(element: HTMLElement | null) => void, number] {
  const [element, setElement] = useState<HTMLElement | null>(null)
  const [width, setWidth] = useState(0)
  useEffect(() => {
    if (!element) return
    const observer = new ResizeObserver(([entry]) => setWidth(Math.floor(entry!.contentRect.width)))
    observer.observe(element)
    return () => observer.disconnect()
  }, [element])
  return [setElement, width]
}
