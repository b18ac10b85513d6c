// A log as a table, the latest entry first: events, alarm history, audit trail.

import './log.css'
import type { ComponentChildren, JSX } from 'preact'
import { useState } from 'preact/hooks'
import { clock, day } from '../lib/format.ts'
import { t } from '../texts/texts.ts'
import { type Query, useQuery } from './hooks.ts'
import { QueryState } from './query-state.tsx'

const REFRESH_MS = 3_000

/** The number of entries at first, and with each press of `Show older entries`. */
const PAGE = 100

export interface Log<T> {
  entries: T[]
  query: Pick<Query<T[]>, 'value' | 'error' | 'again'>
  /** Fetches more entries; `null` if there are no more. */
  showOlder: (() => void) | null
}

/** The latest entries, fetched again when `key` changes and every few seconds. */
export function useLog<T>(
  key: string,
  fetch: (most: number, signal: AbortSignal) => Promise<T[]>,
  periodMs = REFRESH_MS,
): Log<T> {
  const [most, setMost] = useState(PAGE)
  const query = useQuery(`${most} ${key}`, periodMs, (signal) => fetch(most, signal))
  const { value } = query
  const showOlder = value?.length === most ? () => setMost(most + PAGE) : null
  return { entries: value ?? [], query, showOlder }
}

export interface Column<T> {
  title: string
  class?: string
  cell: (entry: T) => ComponentChildren
  /** A press on the head of the column sorts by it. */
  sort?: Sort
}

export interface Sort {
  /** Whether the table is sorted by this column, and how. */
  order: 'ascending' | 'descending' | null
  press: () => void
}

/** The head of a column; with a mark of the direction if the table is sorted by it. */
function Head({ title, sort }: { title: string; sort: Sort | undefined }): JSX.Element {
  if (!sort) return <th scope="col">{title}</th>
  return (
    <th scope="col" aria-sort={sort.order ?? undefined}>
      <button type="button" class="sort" title={t.log.sort(title)} onClick={sort.press}>
        {title}
        {sort.order && <span aria-hidden="true">{sort.order === 'ascending' ? ' ▴' : ' ▾'}</span>}
      </button>
    </th>
  )
}

interface Props<T> {
  caption: string
  columns: Column<T>[]
  log: Log<T>
  /** The entries that pass the filter. */
  shown: T[]
  keyOf: (entry: T) => string | number
  /** The kind of an entry, for tests and styles. */
  kindOf?: (entry: T) => string
  /** The text without entries, and the text if none passes the filter. */
  empty: { none: string; filtered: string; isFiltered: boolean }
}

export function LogTable<T>({ caption, columns, log, shown, keyOf, kindOf, empty }: Props<T>): JSX.Element {
  return (
    <>
      <table class="log stacked">
        <caption class="visually-hidden">{caption}</caption>
        <thead>
          <tr>
            {columns.map(({ title, sort }) => (
              <Head title={title} sort={sort} key={title} />
            ))}
          </tr>
        </thead>
        <tbody>
          {shown.map((entry) => (
            <tr key={keyOf(entry)} data-kind={kindOf?.(entry)}>
              {columns.map((column) => (
                <td class={column.class} data-title={column.title} key={column.title}>
                  {column.cell(entry)}
                </td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
      <QueryState of={[log.query]} empty={shown.length === 0 && (empty.isFiltered ? empty.filtered : empty.none)} />
      {log.showOlder && (
        <button type="button" onClick={log.showOlder}>
          {t.log.older}
        </button>
      )}
    </>
  )
}

/** Day and time of an entry. */
export function Time({ at }: { at: number }): JSX.Element {
  return (
    <>
      <span class="muted">{day(at)}</span> {clock(at)}
    </>
  )
}
