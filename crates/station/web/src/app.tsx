// The frame of all pages: where one can go, how the station is, units, colours, keys.

import type { JSX } from 'preact'
import { useEffect, useState } from 'preact/hooks'
import { useLive, type Live } from './live.ts'
import { Help } from './help.tsx'
import { Alarms } from './pages/alarms.tsx'
import { Audit } from './pages/audit.tsx'
import { Bus } from './pages/bus.tsx'
import { Device } from './pages/device.tsx'
import { Events } from './pages/events.tsx'
import { Overview } from './pages/overview.tsx'
import { Rise } from './pages/rise.tsx'
import { Trends } from './pages/trends.tsx'
import { MastershipMark } from './parts/mastership.tsx'
import { Login } from './pages/login.tsx'
import { AlarmBadge } from './parts/alarm.tsx'
import { Person } from './parts/person.tsx'
import { age } from './pure/format.ts'
import { nextUnit, UNIT_NAMES, type Unit } from './pure/units.ts'
import { lostSentence } from './pure/words.ts'
import { go, Link, nameIn, usePlace } from './router.tsx'
import { isIn, useHere } from './session.ts'
import { nextTheme, setUnit, unit, useTheme, useUnit } from './settings.ts'

export const PAGES = [
  { path: '/', name: 'Overview', key: '1' },
  { path: '/trends', name: 'Trends', key: '2' },
  { path: '/bus', name: 'Bus map', key: '3' },
  { path: '/gauge', name: 'Gauge', key: '4' },
  { path: '/rise', name: 'Rate of rise', key: '5' },
  { path: '/events', name: 'Events', key: '6' },
  { path: '/alarms', name: 'Alarms', key: '7' },
  { path: '/audit', name: 'Audit', key: '8' },
]

export function App(): JSX.Element {
  const { path } = usePlace()
  const live = useLive()
  const { session } = useHere()
  const out = session?.door === 'out'
  const [help, setHelp] = useState(false)
  useKeys(() => setHelp((shown) => !shown))
  const page = PAGES.find((page) => page.path === path || (page.path !== '/' && path.startsWith(`${page.path}/`)))
  const station = live.moment?.station.name
  const gauge = nameIn(path)
  useEffect(() => {
    document.title = [out ? 'Log in' : (gauge ?? page?.name ?? 'No such page'), station ?? 'profivac'].join(' · ')
  }, [page, gauge, station, out])
  return (
    <>
      <a class="skip" href="#main">
        To the contents
      </a>
      <Header current={page?.path} live={live} showHelp={() => setHelp(true)} />
      <main id="main" tabIndex={-1}>
        {out ? (
          <Login />
        ) : (
          <>
            <Trouble live={live} />
            {live.moment ? <Page path={page?.path} /> : <p class="waiting">Waiting for the station …</p>}
          </>
        )}
      </main>
      {help && <Help close={() => setHelp(false)} />}
    </>
  )
}

function Page({ path }: { path: string | undefined }): JSX.Element {
  switch (path) {
    case '/':
      return <Overview />
    case '/trends':
      return <Trends />
    case '/bus':
      return <Bus />
    case '/gauge':
      return <Device />
    case '/rise':
      return <Rise />
    case '/events':
      return <Events />
    case '/alarms':
      return <Alarms />
    case '/audit':
      return <Audit />
    default:
      return (
        <p>
          There is no such page. <Link to="/">To the overview</Link>
        </p>
      )
  }
}

function Header({
  current,
  live,
  showHelp,
}: {
  current: string | undefined
  live: Live
  showHelp: () => void
}): JSX.Element {
  const out = useHere().session?.door === 'out'
  return (
    <header>
      <div class="station">
        <strong>{live.moment?.station.name ?? 'profivac'}</strong>
        {!out && <Heard live={live} />}
        {!out && <AlarmBadge moment={live.moment} />}
      </div>
      {live.moment && !out && <MastershipMark mastership={live.moment.mastership} now={live.now} />}
      <div class="choices">
        <Person />
        {!out && <UnitChoice />}
        <ThemeChoice />
        <button
          type="button"
          class="plain"
          onClick={showHelp}
          aria-label="Help: keys and marks"
          title="Keys and marks (?)"
        >
          ?
        </button>
      </div>
      {!out && <Pages current={current} />}
    </header>
  )
}

function Heard({ live }: { live: Live }): JSX.Element {
  return (
    <span class={live.connected ? 'link good' : 'link lost'} role="status">
      <span class="dot" aria-hidden="true" />
      {live.connected ? 'live' : live.moment ? `lost for ${age(live.since)}` : 'connecting'}
    </span>
  )
}

function Pages({ current }: { current: string | undefined }): JSX.Element {
  return (
    <nav aria-label="Pages">
      {PAGES.map(({ path, name, key }) => (
        <Link to={path} key={path} aria-current={path === current ? 'page' : undefined} aria-keyshortcuts={key}>
          {name}
        </Link>
      ))}
    </nav>
  )
}

function UnitChoice(): JSX.Element {
  const unit = useUnit()
  return (
    <select aria-label="Unit of pressure" value={unit} onChange={(event) => setUnit(event.currentTarget.value as Unit)}>
      {UNIT_NAMES.map((name) => (
        <option value={name} key={name}>
          {name}
        </option>
      ))}
    </select>
  )
}

const THEMES = { auto: '◐', light: '☀', dark: '☾' }

function ThemeChoice(): JSX.Element {
  const theme = useTheme()
  return (
    <button type="button" class="plain theme" onClick={nextTheme} aria-label={`Colours: ${theme}`} title="Colours (t)">
      {THEMES[theme]} <span class="word">{theme}</span>
    </button>
  )
}

/** What makes everything below doubtful. */
function Trouble({ live }: { live: Live }): JSX.Element | null {
  const recorder = live.moment?.station.recorder
  if (live.moment && !live.connected) {
    return (
      <p class="alarm" role="alert">
        The connection to the station is lost. What you see is what was last heard. It is tried again by itself.
      </p>
    )
  }
  if (recorder?.error) {
    return (
      <p class="alarm" role="alert">
        Nothing is being recorded: {recorder.error}
      </p>
    )
  }
  const lost = recorder && lostSentence(recorder)
  return lost ? <p class="alarm">{lost}</p> : null
}

/** Every page by a key, unless somebody writes. */
function useKeys(help: () => void): void {
  useEffect(() => {
    const pressed = (event: KeyboardEvent): void => {
      const target = event.target as HTMLElement
      if (event.ctrlKey || event.metaKey || event.altKey || target.matches('input, select, textarea')) return
      // Nobody goes away from an order that is armed by a key that slipped.
      if (document.querySelector('dialog[open]')) return
      const page = isIn() ? PAGES.find(({ key }) => key === event.key) : undefined
      if (page) go(page.path)
      else if (event.key === '?') help()
      else if (event.key === 'u') setUnit(nextUnit(unit()))
      else if (event.key === 't') nextTheme()
    }
    addEventListener('keydown', pressed)
    return () => removeEventListener('keydown', pressed)
  }, [])
}
