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
import { read, write } from '../storage.ts'
import { createStore, useStore } from '../store.ts'
import { t } from '../texts/texts.ts'

const KEY = 'views'

const own = createStore(viewsIn(read(KEY)))

// Another window of the browser has changed them.
addEventListener('storage', ({ key }) => key === KEY && own.set(viewsIn(read(KEY))))

/** If the browser refuses to store them, they hold until the page is closed. */
function keep(views: NamedView[]): void {
  own.set(views)
  write(KEY, JSON.stringify(views))
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
      <summary>{t.views.title}</summary>
      {all.length > 0 && (
        <ul aria-label={t.views.ofStation}>
          {all.map((view) => (
            <li key={view.name}>{link(view)}</li>
          ))}
        </ul>
      )}
      {mine.length > 0 && (
        <ul aria-label={t.views.own}>
          {mine.map((view) => (
            <li key={view.name}>
              {link(view)}{' '}
              <button
                type="button"
                aria-label={t.views.deleteOf(view.name)}
                onClick={() => keep(withoutView(own.get(), view))}
              >
                {t.views.delete}
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
    return <p class="muted">{page === '/' ? t.views.chooseFilter : t.views.chooseSeries}</p>
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
        {t.views.name}{' '}
        <input
          required
          maxLength={LONGEST_NAME}
          pattern=".*\S.*"
          autocomplete="off"
          value={name}
          onInput={(event) => setName(event.currentTarget.value)}
        />
      </label>
      <button type="submit">{t.views.save}</button>
      <span class="muted">{t.views.inBrowser}</span>
      {error && (
        <span class="error" role="alert">
          {error}
        </span>
      )}
    </form>
  )
}
