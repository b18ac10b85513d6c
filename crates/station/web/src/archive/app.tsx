// The frame of all pages of an archive.

import '../app.css'
import '../components/header.css'
import './archive.css'
import type { JSX } from 'preact'
import { useEffect } from 'preact/hooks'
import { AccountMenu } from '../components/account-menu.tsx'
import { ThemeButton, UnitChoice } from '../components/header.tsx'
import { Login } from '../pages/login.tsx'
import { Link, useLocation } from '../router.tsx'
import { useSessionState } from '../session.ts'
import { Alarms } from './alarms.tsx'
import { Events } from './events.tsx'
import { type Live, useLive } from './live.ts'
import { alarmsOf, isOpen } from './plant.ts'
import { Stations } from './stations.tsx'
import { Trends } from './trends.tsx'

const PAGES: { path: string; name: string; component: () => JSX.Element }[] = [
  { path: '/', name: 'Stations', component: Stations },
  { path: '/trends', name: 'Trends', component: Trends },
  { path: '/alarms', name: 'Alarms', component: Alarms },
  { path: '/events', name: 'Events', component: Events },
]

export function App(): JSX.Element {
  const { path } = useLocation()
  const live = useLive()
  const isLoggedOut = useSessionState().session?.login === 'logged-out'
  const page = PAGES.find((page) => page.path === path)
  useEffect(() => {
    document.title = `${isLoggedOut ? 'Log in' : (page?.name ?? 'Page not found')} · archive`
  }, [page, isLoggedOut])
  return (
    <>
      <a class="skip" href="#main">
        Skip to content
      </a>
      <header>
        <div class="station">
          <strong>All stations</strong>
          {!isLoggedOut && <Connection live={live} />}
          {!isLoggedOut && live.state && <AlarmCount live={live} />}
        </div>
        <div class="choices">
          <AccountMenu />
          {!isLoggedOut && <UnitChoice />}
          <ThemeButton />
        </div>
        {!isLoggedOut && (
          <nav aria-label="Pages">
            {PAGES.map(({ path: to, name }) => (
              <Link to={to} key={to} aria-current={to === path ? 'page' : undefined}>
                {name}
              </Link>
            ))}
          </nav>
        )}
      </header>
      <main id="main" tabIndex={-1}>
        {isLoggedOut ? <Login /> : <Page live={live} component={page?.component} />}
      </main>
    </>
  )
}

function Page({ live, component: Component }: { live: Live; component: (() => JSX.Element) | undefined }): JSX.Element {
  if (!live.state) return <p class="waiting">Waiting for the archive …</p>
  if (!Component) {
    return (
      <p>
        Page not found. <Link to="/">Go to the stations</Link>
      </p>
    )
  }
  const problem = live.connected
    ? live.state.problem
    : 'The connection to the archive is lost. The page shows the last data received and reconnects by itself.'
  return (
    <>
      {problem && (
        <p class="error" role="alert">
          {problem}
        </p>
      )}
      <Component />
    </>
  )
}

function Connection({ live }: { live: Live }): JSX.Element {
  const text = live.connected ? 'live' : live.state ? 'lost' : 'connecting'
  return (
    <span class={live.connected ? 'connection good' : 'connection lost'} role="status">
      <span class="dot" aria-hidden="true" />
      {text}
    </span>
  )
}

/** In the header of all pages: the number of open alarms, and of those that are not acknowledged. */
function AlarmCount({ live }: { live: Live }): JSX.Element {
  const open = live.state ? alarmsOf(live.state).filter(isOpen) : []
  const waiting = open.filter(({ state }) => state !== 'acknowledged').length
  if (open.length === 0) {
    return (
      <Link to="/alarms" class="badge none">
        <span aria-hidden="true">○ </span>no alarms
      </Link>
    )
  }
  const worst = open[0]?.priority ?? 'low'
  return (
    <Link to="/alarms" class={`badge ${worst} ${waiting ? '' : 'acknowledged'}`}>
      {open.length} {open.length === 1 ? 'alarm' : 'alarms'}
      {waiting > 0 && <span class="unacknowledged">, {waiting} not acknowledged</span>}
    </Link>
  )
}
