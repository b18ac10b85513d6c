// Which page is shown: the address of the browser, and links that change it without loading.

import type { ComponentChildren, JSX } from 'preact'
import { useEffect, useState } from 'preact/hooks'

export interface Place {
  path: string
  query: URLSearchParams
}

const here = (): Place => ({ path: location.pathname, query: new URLSearchParams(location.search) })
const isHere = ({ path, query }: Place): boolean =>
  path + query === location.pathname + new URLSearchParams(location.search)
const listeners = new Set<() => void>()

addEventListener('popstate', () => listeners.forEach((listener) => listener()))

export function go(to: string, replace = false): void {
  if (to === location.pathname + location.search) return
  if (replace) history.replaceState(null, '', to)
  else history.pushState(null, '', to)
  listeners.forEach((listener) => listener())
}

/** The same page with other questions in its address. */
export function ask(query: Record<string, string> | URLSearchParams, replace = true): void {
  const text = new URLSearchParams(query).toString()
  go(location.pathname + (text ? `?${text}` : ''), replace)
}

export function usePlace(): Place {
  const [place, setPlace] = useState(here)
  useEffect(() => {
    const listener = (): void => setPlace(here())
    listeners.add(listener)
    // Somebody may have gone on between the first drawing and here; the same place is not drawn again.
    setPlace((place) => (isHere(place) ? place : here()))
    return () => void listeners.delete(listener)
  }, [])
  return place
}

export const gaugePath = (name: string): string => `/gauge/${encodeURIComponent(name)}`

/** The gauge that the address of a page names. */
export function nameIn(path: string): string | null {
  const [, page, name] = path.split('/')
  if (page !== 'gauge' || !name) return null
  try {
    return decodeURIComponent(name)
  } catch {
    return name
  }
}

export function Link({
  to,
  children,
  ...rest
}: { to: string; children: ComponentChildren } & JSX.IntrinsicElements['a']): JSX.Element {
  const follow = (event: MouseEvent): void => {
    if (event.ctrlKey || event.metaKey || event.shiftKey || event.button !== 0) return
    event.preventDefault()
    go(to)
  }
  return (
    <a href={to} onClick={follow} {...rest}>
      {children}
    </a>
  )
}
