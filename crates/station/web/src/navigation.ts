// The pages, in the order of the navigation.

export interface PageEntry {
  path: string
  name: string
  /** The single-key shortcut. */
  key: string
}

export const PAGES: PageEntry[] = [
  { path: '/', name: 'Overview', key: '1' },
  { path: '/plant', name: 'Plant', key: 'p' },
  { path: '/trends', name: 'Trends', key: '2' },
  { path: '/bus', name: 'Bus map', key: '3' },
  { path: '/gauge', name: 'Gauge', key: '4' },
  { path: '/rise', name: 'Rate of rise', key: '5' },
  { path: '/events', name: 'Events', key: '6' },
  { path: '/alarms', name: 'Alarms', key: '7' },
  { path: '/audit', name: 'Audit', key: '8' },
  { path: '/gateways', name: 'Gateways', key: '9' },
]

/** The page of a path; a page may have further parts behind its name. */
export const pageOf = (path: string): PageEntry | undefined =>
  PAGES.find((page) => page.path === path || (page.path !== '/' && path.startsWith(`${page.path}/`)))
