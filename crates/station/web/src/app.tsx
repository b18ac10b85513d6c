// The frame of all pages.

import './app.css'
import type { JSX } from 'preact'
import { useEffect, useState } from 'preact/hooks'
import { Header } from './components/header.tsx'
import { Help } from './components/help.tsx'
import { lostSentence } from './lib/labels.ts'
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
  const isLoggedOut = useSessionState().session?.login === 'logged-out'
  const [help, setHelp] = useState(false)
  useShortcutKeys(() => setHelp(true))
  const page = pageOf(path)
  const station = live.snapshot?.station.name
  const gauge = gaugeIn(path)
  const isWall = path === '/wall' && !isLoggedOut
  useEffect(() => {
    document.title = [
      isLoggedOut ? 'Log in' : (gauge ?? (isWall ? 'Wall display' : page?.name) ?? 'Page not found'),
      station ?? 'profivac',
    ].join(' · ')
  }, [page, gauge, station, isLoggedOut, isWall])
  if (isWall) {
    return <main id="main">{live.snapshot ? <Wall /> : <p class="waiting">Waiting for the station …</p>}</main>
  }
  return (
    <>
      <a class="skip" href="#main">
        Skip to content
      </a>
      <Header current={page?.path} live={live} showHelp={() => setHelp(true)} />
      <main id="main" tabIndex={-1}>
        {isLoggedOut ? (
          <Login />
        ) : (
          <>
            <StationProblem live={live} />
            {live.snapshot ? (
              <Page path={path in PARTS ? path : page?.path} />
            ) : (
              <p class="waiting">Waiting for the station …</p>
            )}
          </>
        )}
      </main>
      {help && <Help close={() => setHelp(false)} />}
    </>
  )
}

function Page({ path }: { path: string | undefined }): JSX.Element {
  const Component = PARTS[path ?? ''] ?? COMPONENTS[path ?? '']
  if (Component) return <Component />
  return (
    <p>
      Page not found. <Link to="/">Go to the overview</Link>
    </p>
  )
}

/** A problem that affects all pages: no connection, or the recorder does not write. */
function StationProblem({ live }: { live: Live }): JSX.Element | null {
  const recorder = live.snapshot?.station.recorder
  if (live.snapshot && !live.connected) {
    return (
      <p class="error" role="alert">
        The connection to the station is lost. The page shows the last data received and reconnects by itself.
      </p>
    )
  }
  if (recorder?.error) {
    return (
      <p class="error" role="alert">
        The recorder does not write: {recorder.error}
      </p>
    )
  }
  const lost = recorder && lostSentence(recorder)
  return lost ? <p class="error">{lost}</p> : null
}
