// Saved views: a filter of the overview or a choice of trends under a name, as an address of the dashboard.

import type { Gauge, SavedView } from '../api/types.ts'
import { t } from '../texts/texts.ts'
import { filterQuery } from './filter.ts'

/** The pages that have views, and what a view of them is called. */
export const VIEW_PAGES = { '/': 'overview', '/trends': 'trends' } as const
export type ViewPage = keyof typeof VIEW_PAGES

export interface NamedView {
  name: string
  page: ViewPage
  /** The query of the address, without its first character. */
  query: string
}

export const LONGEST_NAME = 40
/** The browser keeps at most this many views, of this length. */
const MOST_VIEWS = 100
const LONGEST_QUERY = 4_000

export const viewPath = ({ page, query }: NamedView): string => `${page}?${query}`

/** A view of the station's file. A controller stands for all its channels. */
export function ofStation(view: SavedView, gauges: readonly Gauge[]): NamedView {
  if (view.series.length === 0) {
    const { search, group, tag, location, state } = view
    const query = filterQuery({
      text: search ?? '',
      group: group ?? '',
      tag: tag ?? '',
      location: location ?? '',
      state: state ?? '',
    })
    return { name: view.name, page: '/', query: query.toString() }
  }
  const series = view.series.flatMap((name) => {
    const readings = gauges.find((gauge) => gauge.name === name)?.readings ?? []
    return readings.length > 0 ? readings.map(({ series }) => series) : [name]
  })
  return { name: view.name, page: '/trends', query: new URLSearchParams(series.map((name) => ['s', name])).toString() }
}

/** The views in the storage of the browser. What has another form is left out: another program may have written it. */
export function viewsIn(text: string | null): NamedView[] {
  try {
    const all: unknown = JSON.parse(text ?? '[]')
    return Array.isArray(all) ? all.filter(isView).slice(0, MOST_VIEWS) : []
  } catch {
    return []
  }
}

function isView(value: unknown): value is NamedView {
  if (typeof value !== 'object' || value === null) return false
  const { name, page, query } = value as Record<string, unknown>
  const isText = (text: unknown, most: number): boolean =>
    typeof text === 'string' && text !== '' && text.length <= most
  return (
    typeof page === 'string' &&
    Object.hasOwn(VIEW_PAGES, page) &&
    isText(name, LONGEST_NAME) &&
    isText(query, LONGEST_QUERY)
  )
}

/** The views with a new one; one of the same name and page is replaced. The reason, if the browser cannot keep it. */
export function withView(views: readonly NamedView[], view: NamedView): NamedView[] | string {
  if (view.query.length > LONGEST_QUERY) return t.views.tooLong
  const others = views.filter(({ name, page }) => name !== view.name || page !== view.page)
  if (others.length >= MOST_VIEWS) return t.views.tooMany(MOST_VIEWS)
  return [...others, view].sort((one, other) => one.name.localeCompare(other.name, 'en', { numeric: true }))
}

export const withoutView = (views: readonly NamedView[], view: NamedView): NamedView[] =>
  views.filter(({ name, page }) => name !== view.name || page !== view.page)
