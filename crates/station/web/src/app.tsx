// The frame of all pages.

import './app.css'
import type { JSX } from 'preact'
import { useEffect, useLayoutEffect, useState } from 'preact/hooks'
import { Boundary } from './components/boundary.tsx'
import { Header } from './components/header.tsx'
import { Help } from './components/help.tsx'
import { useLanguage } from './language.ts'
import { summary } from './lib/alarms.ts'
import { clock } from './lib/format.ts'
import { lostSentence, recorderProblem } from './lib/labels.ts'
import { type Live, useLive } from './live.ts'
import { pageOf } from './navigation.ts'
import { Alarms } from './pages/alarms/alarms.tsx'
import { Audit } from './pages/audit.tsx'
import { BusMap } from './pages/bus.tsx'
import { Events } from './pages/events.tsx'
import { Gateways } from './pages/gateways.tsx'
import { GaugePage } from './pages/gauge/gauge.tsx'
import { Identify } from './pages/identify/identify.tsx'
import { Login } from './pages/login.tsx'
import { Overview } from './pages/overview.tsx'
import { PlantPage } from './pages/plant.tsx'
import { RateOfRise } from './pages/rise/rise.tsx'
import { PumpDowns } from './pages/trends/pump-downs.tsx'
import { Trends } from './pages/trends/trends.tsx'
import { Wall } from './pages/wall.tsx'
import { gaugeIn, Link, useLocation } from './router.tsx'
import { useSessionState } from './session.ts'
import { useShortcutKeys } from './shortcuts.ts'
import { t } from './texts/texts.ts'

const COMPONENTS: Record<string, () => JSX.Element> = {
  '/': Overview,
  '/plant': PlantPage,
  '/trends': Trends,
  '/bus': BusMap,
  '/gauge': GaugePage,
  '/rise': RateOfRise,
  '/events': Events,
  '/alarms': Alarms,
  '/audit': Audit,
  '/gateways': Gateways,
}

/** Pages below those of the navigation. */
const PARTS: Record<string, () => JSX.Element> = {
  '/trends/pump-downs': PumpDowns,
  '/rise/identify': Identify,
}

export function App(): JSX.Element {
  const { path } = useLocation()
  const live = useLive()
  // A new language draws all components again.
  const language = useLanguage()
  const isLoggedOut = useSessionState().session?.login === 'logged-out'
  const [help, setHelp] = useState(false)
  useShortcutKeys(() => setHelp(true))
  const page = pageOf(path)
  const station = live.snapshot?.station.name
  const gauge = gaugeIn(path)
  const isWall = path === '/wall' && !isLoggedOut
  const unacknowledged = (live.snapshot && summary(live.snapshot.alarms)?.unacknowledged) ?? 0
  useEffect(() => {
    const shown = isWall ? t.wall.title : page ? t.pages[page.path] : t.app.notFound
    const words = [isLoggedOut ? t.login.title : (gauge ?? shown), station ?? 'profivac'].join(' · ')
    // A window in the background shows only this.
    document.title = unacknowledged > 0 && !isLoggedOut ? `(${unacknowledged}) ${words}` : words
  }, [page, gauge, station, isLoggedOut, isWall, language, unacknowledged])
  const isLost = live.snapshot !== null && !live.connected
  useLayoutEffect(() => {
    document.documentElement.toggleAttribute('data-lost', isLost)
  }, [isLost])
  if (isWall) {
    return <main id="main">{live.snapshot ? <Wall /> : <p class="waiting">{t.app.waiting}</p>}</main>
  }
  return (
    <>
      <a class="skip" href="#main">
        {t.app.skip}
      </a>
      {path === '/alarms' && !isLoggedOut && (
        <button type="button" class="skip" onClick={focusFirstAlarm}>
          {t.alarms.toFirst}
        </button>
      )}
      <Header current={page?.path} live={live} showHelp={() => setHelp(true)} />
      <main id="main" tabIndex={-1}>
        {isLoggedOut ? (
          <Login />
        ) : (
          <>
            <StationProblem live={live} />
            {live.snapshot ? (
              <Boundary page={path}>
                <Page path={path in PARTS ? path : page?.path} />
              </Boundary>
            ) : (
              <p class="waiting">{t.app.waiting}</p>
            )}
          </>
        )}
      </main>
      {help && <Help close={() => setHelp(false)} />}
    </>
  )
}

/** The first button that acknowledges, or else the first alarm or group. */
function focusFirstAlarm(): void {
  for (const first of ['.alarm-line .acknowledge', '.alarm-line .name', '.alarm-group>details>summary']) {
    const found = document.querySelector<HTMLElement>(first)
    if (found) {
      found.focus()
      return
    }
  }
}

function Page({ path }: { path: string | undefined }): JSX.Element {
  const Component = PARTS[path ?? ''] ?? COMPONENTS[path ?? '']
  if (Component) return <Component />
  return (
    <p>
      {t.app.notFound}. <Link to="/">{t.app.toOverview}</Link>
    </p>
  )
}

/** A problem that affects all pages: no connection, the recorder does not write, or its database is damaged. */
function StationProblem({ live }: { live: Live }): JSX.Element | null {
  const recorder = live.snapshot?.station.recorder
  if (live.snapshot && !live.connected) {
    return (
      <p class="error" role="alert">
        {t.app.lost(clock(live.now - live.since))}
      </p>
    )
  }
  const problem = recorder && recorderProblem(recorder)
  if (problem) {
    return (
      <p class="error" role="alert">
        {problem}
      </p>
    )
  }
  const lost = recorder && lostSentence(recorder)
  return lost ? <p class="error">{lost}</p> : null
}
