// The page that is shown: the address of the browser, and links that change it without loading.

import type { ComponentChildren, JSX } from 'preact'
import { createStore, useStore } from './store.ts'

export interface Location {
  path: string
  query: URLSearchParams
}

const current = (): Location => ({ path: location.pathname, query: new URLSearchParams(location.search) })

const store = createStore(current())

addEventListener('popstate', () => store.set(current()))

export function go(to: string, replace = false): void {
  if (to === location.pathname + location.search) return
  if (replace) history.replaceState(null, '', to)
  else history.pushState(null, '', to)
  store.set(current())
}

/** Shows the same page with another query in its address. */
export function setQuery(query: URLSearchParams): void {
  const text = query.toString()
  go(location.pathname + (text ? `?${text}` : ''), true)
}

export const useLocation = (): Location => useStore(store)

export const gaugePath = (name: string): string => `/gauge/${encodeURIComponent(name)}`

/** The name of the gauge in the path of a page. */
export function gaugeIn(path: string): string | null {
  const [, page, name] = path.split('/')
  if (page !== 'gauge' || !name) return null
  try {
    return decodeURIComponent(name)
  } catch {
    return name
  }
}

type LinkProps = { to: string; children: ComponentChildren } & JSX.IntrinsicElements['a']

export function Link({ to, children, ...rest }: LinkProps): JSX.Element {
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
