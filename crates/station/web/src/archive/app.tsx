// The frame of all pages of an archive.

import '../app.css'
import '../components/header.css'
import './archive.css'
import type { JSX } from 'preact'
import { useEffect } from 'preact/hooks'
import { AccountMenu } from '../components/account-menu.tsx'
import { LanguageButton, ThemeButton, UnitChoice } from '../components/header.tsx'
import { useLanguage } from '../language.ts'
import { isActive } from '../lib/alarms.ts'
import { Login } from '../pages/login.tsx'
import { Link, useLocation } from '../router.tsx'
import { useSessionState } from '../session.ts'
import { t } from '../texts/texts.ts'
import { Alarms } from './alarms.tsx'
import { Events } from './events.tsx'
import { type Live, useLive } from './live.ts'
import { alarmsOf, isOpen } from './plant.ts'
import { Stations } from './stations.tsx'
import { Trends } from './trends.tsx'

const PAGES: { path: string; name: () => string; component: () => JSX.Element }[] = [
  { path: '/', name: () => t.archive.stations, component: Stations },
  { path: '/trends', name: () => t.pages['/trends'], component: Trends },
  { path: '/alarms', name: () => t.pages['/alarms'], component: Alarms },
  { path: '/events', name: () => t.pages['/events'], component: Events },
]

export function App(): JSX.Element {
  const { path } = useLocation()
  const live = useLive()
  // A new language draws all components again.
  const language = useLanguage()
  const isLoggedOut = useSessionState().session?.login === 'logged-out'
  const page = PAGES.find((page) => page.path === path)
  useEffect(() => {
    document.title = `${isLoggedOut ? t.login.title : (page?.name() ?? t.app.notFound)} · ${t.archive.title}`
  }, [page, isLoggedOut, language])
  return (
    <>
      <a class="skip" href="#main">
        {t.app.skip}
      </a>
      <header>
        <div class="station">
          <strong>{t.archive.all}</strong>
          {!isLoggedOut && <Connection live={live} />}
          {!isLoggedOut && live.state && <AlarmCount live={live} />}
        </div>
        <div class="choices">
          <AccountMenu />
          {!isLoggedOut && <UnitChoice />}
          <LanguageButton />
          <ThemeButton />
        </div>
        {!isLoggedOut && (
          <nav aria-label={t.app.pages}>
            {PAGES.map(({ path: to, name }) => (
              <Link to={to} key={to} aria-current={to === path ? 'page' : undefined}>
                {name()}
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
  if (!live.state) return <p class="waiting">{t.archive.waiting}</p>
  if (!Component) {
    return (
      <p>
        {t.app.notFound}. <Link to="/">{t.archive.toStations}</Link>
      </p>
    )
  }
  const problem = live.connected ? live.state.problem : t.archive.lost
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
  const state = live.connected ? 'good' : live.state ? 'lost' : 'connecting'
  const text = { good: t.header.live, lost: t.header.lost, connecting: t.header.connecting }[state]
  return (
    <span class={`connection ${state}`} role="status">
      <span class="dot" aria-hidden="true" />
      {text}
    </span>
  )
}

/** In the header of all pages: the number of active alarms, and of those that are not acknowledged, also cleared ones. */
function AlarmCount({ live }: { live: Live }): JSX.Element {
  const open = live.state ? alarmsOf(live.state).filter(isOpen) : []
  const waiting = open.filter(({ state }) => state !== 'acknowledged').length
  if (open.length === 0) {
    return (
      <Link to="/alarms" class="badge none">
        <span aria-hidden="true">○ </span>
        {t.alarms.badge.none}
      </Link>
    )
  }
  const worst = open[0]?.priority ?? 'low'
  const active = t.archive.alarms(open.filter(isActive).length)
  // The archive lists the most urgent ones.
  const isCut = (live.state?.not_listed ?? 0) > 0
  return (
    <Link to="/alarms" class={`badge ${worst} ${waiting ? '' : 'acknowledged'}`}>
      {isCut ? t.archive.atLeast(active) : active}
      {waiting > 0 && <span class="unacknowledged">{t.archive.notAcknowledged(waiting)}</span>}
    </Link>
  )
}
