// The data of a chart as a table, for those who do not see the curves.

import './chart-table.css'
import type { ComponentChildren, JSX } from 'preact'
import { useState } from 'preact/hooks'
import { moment } from '../lib/format.ts'
import { tableTimes } from '../lib/range.ts'
import { t } from '../texts/texts.ts'

const MOST_ROWS = 30

interface Column {
  name: string
  cell: (at: number) => ComponentChildren
}

interface Props {
  caption: string
  window: [number, number]
  columns: Column[]
}

export function ChartTable(props: Props): JSX.Element {
  const [open, setOpen] = useState(false)
  return (
    <details class="chart-table" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>{t.chartTable.title}</summary>
      {open && <Table {...props} />}
    </details>
  )
}

function Table({ caption, window, columns }: Props): JSX.Element {
  return (
    // biome-ignore lint/a11y/noNoninteractiveTabindex: it scrolls with the arrow keys
    <section class="scroll" tabIndex={0} aria-label={t.chartTable.title}>
      <table>
        <caption class="muted">{t.chartTable.caption(caption)}</caption>
        <thead>
          <tr>
            <th scope="col">{t.common.time}</th>
            {columns.map(({ name }) => (
              <th scope="col" key={name}>
                {name}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {tableTimes(window, MOST_ROWS).map((at) => (
            <tr key={at}>
              <th scope="row">{moment(at)}</th>
              {columns.map(({ name, cell }) => (
                <td key={name}>{cell(at)}</td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </section>
  )
}
