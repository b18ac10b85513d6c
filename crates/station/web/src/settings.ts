// What this browser remembers: the unit and the colours.

import { useEffect, useState } from 'preact/hooks'
import { isUnit, type Unit } from './pure/units.ts'

export type Theme = 'auto' | 'light' | 'dark'
const THEMES: Theme[] = ['auto', 'light', 'dark']

const listeners = new Set<() => void>()

/** A browser may refuse to remember; then the choice holds until the page is closed. */
const memory = new Map<string, string>()

function recall(name: string): string | null {
  try {
    return localStorage.getItem(name) ?? memory.get(name) ?? null
  } catch {
    return memory.get(name) ?? null
  }
}

function remember(name: string, value: string): void {
  memory.set(name, value)
  try {
    localStorage.setItem(name, value)
  } catch {
    // Told above.
  }
  listeners.forEach((listener) => listener())
}

export function unit(): Unit {
  const kept = recall('unit')
  return isUnit(kept) ? kept : 'mbar'
}

export function setUnit(unit: Unit): void {
  remember('unit', unit)
}

export function theme(): Theme {
  const kept = recall('theme') as Theme | null
  return kept && THEMES.includes(kept) ? kept : 'auto'
}

export function setTheme(theme: Theme): void {
  remember('theme', theme)
  applyTheme()
}

export function nextTheme(): void {
  setTheme(THEMES[(THEMES.indexOf(theme()) + 1) % THEMES.length]!)
}

export function applyTheme(): void {
  document.documentElement.dataset['theme'] = theme()
}

const dark = matchMedia('(prefers-color-scheme: dark)')

export function isDark(): boolean {
  return theme() === 'dark' || (theme() === 'auto' && dark.matches)
}

function useSetting<T>(read: () => T): T {
  const [value, setValue] = useState(read)
  useEffect(() => {
    const changed = (): void => setValue(read)
    listeners.add(changed)
    dark.addEventListener('change', changed)
    // It may have changed between the first drawing and here.
    changed()
    return () => {
      listeners.delete(changed)
      dark.removeEventListener('change', changed)
    }
  }, [])
  return value
}

export const useUnit = (): Unit => useSetting(unit)
export const useTheme = (): Theme => useSetting(theme)
export const useDark = (): boolean => useSetting(isDark)
