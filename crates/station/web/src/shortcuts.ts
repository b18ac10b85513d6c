// Single-key shortcuts for pages, unit, theme and help.

import { useEffect } from 'preact/hooks'
import { nextUnit } from './lib/units.ts'
import { PAGES } from './navigation.ts'
import { go } from './router.tsx'
import { canView } from './session.ts'
import { areShortcutsOn, nextTheme, setUnit, unit } from './settings.ts'

export function useShortcutKeys(showHelp: () => void): void {
  useEffect(() => {
    const pressed = (event: KeyboardEvent): void => {
      if (isIgnored(event)) return
      const page = canView() ? PAGES.find(({ key }) => key === event.key) : undefined
      if (page) go(page.path)
      else if (event.key === '?') showHelp()
      else if (event.key === 'u') setUnit(nextUnit(unit()))
      else if (event.key === 't') nextTheme()
    }
    addEventListener('keydown', pressed)
    return () => removeEventListener('keydown', pressed)
  }, [])
}

/** Shortcuts do nothing while the user types, and while a dialog is open: no key leads away from an armed command. */
function isIgnored({ target, ctrlKey, metaKey, altKey }: KeyboardEvent): boolean {
  if (!areShortcutsOn() || ctrlKey || metaKey || altKey) return true
  const isField = target instanceof Element && target.matches('input, select, textarea')
  return isField || document.querySelector('dialog[open]') !== null
}
