// The views of a page: those of the station's file, and those that the user has saved in this browser.

import './views.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import type { Directory } from '../api/types.ts'
import {
  LONGEST_NAME,
  type NamedView,
  ofStation,
  type ViewPage,
  viewPath,
  viewsIn,
  withoutView,
  withView,
} from '../lib/views.ts'
import { useSnapshot } from '../live.ts'
import { Link, useLocation } from '../router.tsx'
import { createStore, useStore } from '../store.ts'

const KEY = 'views'

function read(): NamedView[] {
  try {
    return viewsIn(localStorage.getItem(KEY))
  } catch {
    return []
  }
}

const own = createStore(read())

// Another window of the browser has changed them.
addEventListener('storage', ({ key }) => key === KEY && own.set(read()))

/** If the browser refuses to store them, they hold until the page is closed. */
function keep(views: NamedView[]): void {
  own.set(views)
  try {
    localStorage.setItem(KEY, JSON.stringify(views))
  } catch {
    // See above.
  }
}

/** A list of views that opens, and a form that saves what the page shows. */
export function Views({ page, directory }: { page: ViewPage; directory: Directory | null }): JSX.Element {
  const { gauges } = useSnapshot()
  const current = useLocation().query.toString()
  const all = (directory?.views ?? []).map((view) => ofStation(view, gauges)).filter((view) => view.page === page)
  const mine = useStore(own).filter((view) => view.page === page)
  const link = (view: NamedView): JSX.Element => (
    <Link to={viewPath(view)} aria-current={view.query === current ? 'page' : undefined}>
      {view.name}
    </Link>
  )
  return (
    <details class="views">
      <summary>Views</summary>
      {all.length > 0 && (
        <ul aria-label="Views of the station">
          {all.map((view) => (
            <li key={view.name}>{link(view)}</li>
          ))}
        </ul>
      )}
      {mine.length > 0 && (
        <ul aria-label="Your views">
          {mine.map((view) => (
            <li key={view.name}>
              {link(view)}{' '}
              <button
                type="button"
                aria-label={`Delete the view ${view.name}`}
                onClick={() => keep(withoutView(own.get(), view))}
              >
                Delete
              </button>
            </li>
          ))}
        </ul>
      )}
      <SaveView page={page} query={current} />
    </details>
  )
}

function SaveView({ page, query }: { page: ViewPage; query: string }): JSX.Element {
  const [name, setName] = useState('')
  const [error, setError] = useState<string | null>(null)
  if (query === '') {
    const first = page === '/' ? 'a filter' : 'series or a time'
    return <p class="muted">Choose {first} first; then save it here under a name.</p>
  }
  const submit = (event: Event): void => {
    event.preventDefault()
    const views = withView(own.get(), { name: name.trim(), page, query })
    if (typeof views === 'string') {
      setError(views)
      return
    }
    keep(views)
    setError(null)
    setName('')
  }
  return (
    <form onSubmit={submit}>
      <label>
        Name{' '}
        <input
          required
          maxLength={LONGEST_NAME}
          pattern=".*\S.*"
          autocomplete="off"
          value={name}
          onInput={(event) => setName(event.currentTarget.value)}
        />
      </label>
      <button type="submit">Save this view</button>
      <span class="muted">in this browser</span>
      {error && (
        <span class="error" role="alert">
          {error}
        </span>
      )}
    </form>
  )
}
