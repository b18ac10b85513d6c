// Hooks: data that is fetched again and again, the width of an element, an open dialog.

import type { RefObject } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'
import { RequestError } from '../api/request.ts'

export interface Query<T> {
  /** The last answer; `null` before the first. */
  value: T | null
  error: string | null
  /** Fetches now, after a failure. */
  again: () => void
}

/** A request without an answer is repeated after this time, also without a period. */
const RETRY_MS = 3_000

/** Fetches whenever `key` changes, and every `periodMs`. The last answer stays until the next one arrives. */
export function useQuery<T>(
  key: string,
  periodMs: number | null,
  fetch: (signal: AbortSignal) => Promise<T>,
): Query<T> {
  const [query, setQuery] = useState<Omit<Query<T>, 'again'>>({ value: null, error: null })
  const [attempts, setAttempts] = useState(0)
  const latest = useRef(fetch)
  latest.current = fetch
  useEffect(() => {
    const abort = new AbortController()
    let timer: number | undefined
    const once = async (): Promise<void> => {
      let next = periodMs
      try {
        const value = await latest.current(abort.signal)
        if (!abort.signal.aborted) setQuery({ value, error: null })
      } catch (error) {
        if (!abort.signal.aborted) setQuery((before) => ({ ...before, error: errorText(error) }))
        if (error instanceof RequestError && error.status === 0) next ??= RETRY_MS
      }
      if (!abort.signal.aborted && next !== null) timer = window.setTimeout(once, next)
    }
    void once()
    return () => {
      abort.abort()
      clearTimeout(timer)
    }
  }, [key, periodMs, attempts])
  const again = (): void => {
    setQuery((before) => ({ ...before, error: null }))
    setAttempts((count) => count + 1)
  }
  return { ...query, again }
}

export function errorText(error: unknown): string {
  return error instanceof Error ? error.message : String(error)
}

/** The width of an element in pixels; 0 before it is known. */
export function useWidth(): [(element: HTMLElement | null) => void, number] {
  const [element, setElement] = useState<HTMLElement | null>(null)
  const [width, setWidth] = useState(0)
  useEffect(() => {
    if (!element) return
    const observer = new ResizeObserver(([entry]) => entry && setWidth(Math.floor(entry.contentRect.width)))
    observer.observe(element)
    return () => observer.disconnect()
  }, [element])
  return [setElement, width]
}

/** The width of the page, whatever stands beside an element. */
export function usePageWidth(): number {
  const [width, setWidth] = useState(innerWidth)
  useEffect(() => {
    const resized = (): void => setWidth(document.documentElement.clientWidth)
    resized()
    addEventListener('resize', resized)
    return () => removeEventListener('resize', resized)
  }, [])
  return width
}

/** A dialog that opens over the page as soon as it is drawn. */
export function useModal(): RefObject<HTMLDialogElement> {
  const dialog = useRef<HTMLDialogElement>(null)
  useEffect(() => dialog.current?.showModal(), [])
  return dialog
}
