// Settings that the browser keeps: unit, theme, single-key shortcuts, sound of alarms.

import { isUnit, type Unit } from './lib/units.ts'
import { read, write } from './storage.ts'
import { createStore, useStore } from './store.ts'

export type Theme = 'auto' | 'light' | 'dark'
const THEMES: Theme[] = ['auto', 'light', 'dark']

interface Settings {
  unit: Unit
  theme: Theme
  /** Whether single keys change pages, unit and theme. */
  shortcuts: boolean
  /** Whether alarms sound. */
  sound: boolean
  /** Whether the system asks for dark colours. */
  systemDark: boolean
}

const isTheme = (text: string | null): text is Theme => THEMES.some((theme) => theme === text)

const systemTheme = matchMedia('(prefers-color-scheme: dark)')

function load(): Settings {
  const [unit, theme] = [read('unit'), read('theme')]
  return {
    unit: isUnit(unit) ? unit : 'mbar',
    theme: isTheme(theme) ? theme : 'auto',
    shortcuts: read('shortcuts') !== 'off',
    sound: read('sound') === 'on',
    systemDark: systemTheme.matches,
  }
}

const store = createStore(load())

systemTheme.addEventListener('change', ({ matches }) => store.set({ ...store.get(), systemDark: matches }))

/** If the browser refuses to store it, the setting holds until the page is closed. */
function save(name: string, text: string, change: Partial<Settings>): void {
  write(name, text)
  store.set({ ...store.get(), ...change })
}

export const unit = (): Unit => store.get().unit
export const setUnit = (unit: Unit): void => save('unit', unit, { unit })

export function nextTheme(): void {
  const theme = THEMES[(THEMES.indexOf(store.get().theme) + 1) % THEMES.length] ?? 'auto'
  save('theme', theme, { theme })
  applyTheme()
}

/** Chooses the colours in styles/tokens.css. */
export function applyTheme(): void {
  document.documentElement.dataset.theme = store.get().theme
}

export const areShortcutsOn = (): boolean => store.get().shortcuts
export const setShortcuts = (shortcuts: boolean): void => save('shortcuts', shortcuts ? 'on' : 'off', { shortcuts })

export const setSound = (sound: boolean): void => save('sound', sound ? 'on' : 'off', { sound })

export const useUnit = (): Unit => useStore(store, ({ unit }) => unit)
export const useTheme = (): Theme => useStore(store, ({ theme }) => theme)
export const useShortcuts = (): boolean => useStore(store, ({ shortcuts }) => shortcuts)
export const useSound = (): boolean => useStore(store, ({ sound }) => sound)
export const useDark = (): boolean =>
  useStore(store, ({ theme, systemDark }) => theme === 'dark' || (theme === 'auto' && systemDark))
