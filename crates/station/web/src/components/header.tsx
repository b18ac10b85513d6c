// The header of all pages: connection, alarms, control, user, unit, theme, navigation.

import './header.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { chooseLanguage, useLanguage } from '../language.ts'
import { age } from '../lib/format.ts'
import { isUnit, UNIT_NAMES } from '../lib/units.ts'
import type { Live } from '../live.ts'
import { PAGES } from '../navigation.ts'
import { Link } from '../router.tsx'
import { useSessionState } from '../session.ts'
import { nextTheme, setUnit, useShortcuts, useTheme, useUnit } from '../settings.ts'
import { LANGUAGES, type Language, t } from '../texts/texts.ts'
import { AccountMenu } from './account-menu.tsx'
import { AlarmBadge } from './alarm-marks.tsx'
import { AlarmSound } from './alarm-sound.tsx'
import { ControlStatus } from './control.tsx'
import { Choice, sameText } from './fields.tsx'
import { PlantStateMark } from './plant-state-mark.tsx'
import { StoppedMark } from './stopped-mark.tsx'

interface Props {
  /** The path of the page that is shown. */
  current: string | undefined
  live: Live
  showHelp: () => void
}

export function Header({ current, live, showHelp }: Props): JSX.Element {
  const { snapshot } = live
  const isLoggedOut = useSessionState().session?.login === 'logged-out'
  const [isOpen, setOpen] = useState(false)
  return (
    <header class={isOpen ? undefined : 'closed'}>
      <div class="station">
        <strong>{snapshot?.station.name ?? 'profivac'}</strong>
        {!isLoggedOut && <Connection live={live} />}
        {!isLoggedOut && snapshot && <AlarmBadge snapshot={snapshot} current={live.connected} />}
        {!isLoggedOut && snapshot && <AlarmSound />}
        {!isLoggedOut && snapshot && <PlantStateMark snapshot={snapshot} />}
        {!isLoggedOut && snapshot && <StoppedMark snapshot={snapshot} />}
      </div>
      <MenuButton isOpen={isOpen} setOpen={setOpen} />
      {snapshot && !isLoggedOut && (
        <ControlStatus control={snapshot.control_authority} now={live.now} connected={live.connected} />
      )}
      <div class="choices">
        <AccountMenu />
        {!isLoggedOut && <UnitChoice />}
        <LanguageButton />
        <ThemeButton />
        <button type="button" onClick={showHelp} aria-label={t.header.help} title={t.header.helpKey}>
          ?
        </button>
      </div>
      {!isLoggedOut && <Navigation current={current} />}
    </header>
  )
}

/** On a phone: shows control, unit, language, theme and help, which have a row of their own there. */
function MenuButton({ isOpen, setOpen }: { isOpen: boolean; setOpen: (isOpen: boolean) => void }): JSX.Element {
  return (
    <button
      type="button"
      class="menu"
      aria-expanded={isOpen}
      aria-label={t.header.menu}
      title={t.header.menu}
      onClick={() => setOpen(!isOpen)}
    >
      ☰
    </button>
  )
}

function Connection({ live }: { live: Live }): JSX.Element {
  const state = live.connected ? 'good' : live.snapshot ? 'lost' : 'connecting'
  const text = { good: t.header.live, lost: t.header.lostFor(age(live.since)), connecting: t.header.connecting }[state]
  return (
    <span class={`connection ${state}`} role="status">
      <span class="dot" aria-hidden="true" />
      {text}
    </span>
  )
}

function Navigation({ current }: { current: string | undefined }): JSX.Element {
  const hasShortcuts = useShortcuts()
  return (
    <nav aria-label={t.app.pages}>
      {PAGES.map(({ path, key }) => (
        <Link
          to={path}
          key={path}
          aria-current={path === current ? 'page' : undefined}
          aria-keyshortcuts={hasShortcuts ? key : undefined}
        >
          {t.pages[path]}
        </Link>
      ))}
    </nav>
  )
}

export function UnitChoice(): JSX.Element {
  const change = (name: string): void => {
    if (isUnit(name)) setUnit(name)
  }
  return <Choice label={t.header.unit} value={useUnit()} options={sameText(UNIT_NAMES)} onChange={change} />
}

/** Shows the pages in the other language, which is named in itself: who does not read the present one finds the own. */
export function LanguageButton(): JSX.Element {
  const other: Language = useLanguage() === 'en' ? 'de' : 'en'
  const name = LANGUAGES[other]
  return (
    <button type="button" lang={other} title={name} onClick={() => void chooseLanguage(other)}>
      <span class="language-name">{name}</span>
      <span class="language-code">{other.toUpperCase()}</span>
    </button>
  )
}

const THEME_SYMBOLS = { auto: '◐', light: '☀', dark: '☾' }

export function ThemeButton(): JSX.Element {
  const theme = useTheme()
  return (
    <button
      type="button"
      class="theme"
      onClick={nextTheme}
      aria-label={t.header.theme(t.header.themes[theme])}
      title={t.header.themeKey}
    >
      {THEME_SYMBOLS[theme]} <span class="theme-name">{t.header.themes[theme]}</span>
    </button>
  )
}
