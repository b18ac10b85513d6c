// The pages, in the order of the navigation.

import type { Texts } from './texts/texts.ts'

export interface PageEntry {
  /** Its name is `t.pages[path]`. */
  path: keyof Texts['pages']
  /** The single-key shortcut. */
  key: string
}

export const PAGES: PageEntry[] = [
  { path: '/', key: '1' },
  { path: '/plant', key: 'p' },
  { path: '/trends', key: '2' },
  { path: '/bus', key: '3' },
  { path: '/gauge', key: '4' },
  { path: '/rise', key: '5' },
  { path: '/events', key: '6' },
  { path: '/alarms', key: '7' },
  { path: '/audit', key: '8' },
  { path: '/gateways', key: '9' },
]

/** The page of a path; a page may have further parts behind its name. */
export const pageOf = (path: string): PageEntry | undefined =>
  PAGES.find((page) => page.path === path || (page.path !== '/' && path.startsWith(`${page.path}/`)))
