// All parameters of a gauge, read from it on request.

import './parameters.css'
import type { JSX } from 'preact'
import { useEffect, useState } from 'preact/hooks'
import { readBlocks } from '../../api/calls.ts'
import type { Block, Gauge, Outcome, Parameter, Request } from '../../api/types.ts'
import { SearchField } from '../../components/fields.tsx'
import { errorText } from '../../components/hooks.ts'
import { changesState } from '../../lib/commands.ts'
import { age, clock, readable } from '../../lib/format.ts'
import { matchingBlocks } from '../../lib/search.ts'
import { useLive } from '../../live.ts'
import { canView, onSessionChange } from '../../session.ts'
import { t } from '../../texts/texts.ts'
import { ChangeParameter } from './change-parameter.tsx'
import { Compare } from './compare.tsx'

export interface Read {
  blocks: Block[] | null
  at: number | null
  error: string | null
}

const NOTHING_READ: Read = { blocks: null, at: null, error: null }

/** The parameters that were read are kept while the dashboard is open, because reading takes bus time. */
const kept = new Map<string, Read>()
onSessionChange(() => {
  if (!canView()) kept.clear()
})

interface Props {
  gauge: Gauge
  open: (request: Request) => void
  reading: Reading
}

export function Parameters({ gauge, open, reading: { read, startedAt, readAgain } }: Props): JSX.Element {
  const [text, setText] = useState('')
  const found = matchingBlocks(read.blocks ?? [], text)
  return (
    <section class="panel parameter-blocks" aria-label={t.gauge.parameters} aria-busy={startedAt !== null}>
      <div class="bar">
        <h2>{t.gauge.parameters}</h2>
        <SearchField label={t.gauge.searchParameters} value={text} onInput={setText} />
        <button type="button" class="main" onClick={readAgain} disabled={startedAt !== null}>
          {t.gauge.readAgain}
        </button>
        <Progress gauge={gauge} startedAt={startedAt} read={read} />
      </div>
      {read.error && <p class="error">{read.error}</p>}
      {read.blocks && <Compare gauge={gauge} blocks={read.blocks} open={open} />}
      {found.map(({ name, parameters }) => (
        <details open key={name}>
          <summary>
            {name} <span class="muted">{parameters.length}</span>
          </summary>
          <Table block={name} parameters={parameters} open={open} />
        </details>
      ))}
      {read.blocks && found.length === 0 && <p class="muted">{t.gauge.noMatch(text)}</p>}
    </section>
  )
}

export interface Reading {
  read: Read
  /** When the present reading was started; `null` if none is under way. */
  startedAt: number | null
  readAgain: () => Promise<void>
}

/** All parameters of the gauge, read when its page is opened. `outcome`: that of the last command or change. */
export function useParameters(gauge: Gauge, outcome: Outcome | null): Reading {
  const [read, setRead] = useState<Read>(kept.get(gauge.name) ?? NOTHING_READ)
  const [startedAt, setStartedAt] = useState<number | null>(null)
  const keep = (next: Read): void => {
    kept.set(gauge.name, next)
    setRead(next)
  }
  const readAgain = async (): Promise<void> => {
    setStartedAt(performance.now())
    const next: Read = await readBlocks(gauge.name).then(
      (blocks) => ({ blocks, at: Date.now(), error: null }),
      (error: unknown) => ({ ...read, error: errorText(error) }),
    )
    keep(next)
    setStartedAt(null)
  }
  useEffect(() => {
    if (!kept.has(gauge.name) && (gauge.state === 'data-exchange' || gauge.state === 'fault')) void readAgain()
  }, [])
  // The station reads a parameter back after it has written it, so the outcome has its new value.
  useEffect(() => {
    if (outcome === null || read.blocks === null) return
    if (outcome.after === null) {
      if (changesState(outcome.target)) void readAgain()
      return
    }
    const changed = ({ name, parameters }: Block): Block => ({
      name,
      parameters: parameters.map((parameter) => withOutcome(parameter, outcome)),
    })
    keep({ ...read, blocks: read.blocks.map(changed) })
  }, [outcome])
  return { read, startedAt, readAgain }
}

function withOutcome(parameter: Parameter, { target, after }: Outcome): Parameter {
  return parameter.target === target ? { ...parameter, value: after, read_error: null } : parameter
}

function Progress({ gauge, startedAt, read }: { gauge: Gauge; startedAt: number | null; read: Read }): JSX.Element {
  const progress = useLive().snapshot?.read_progress.find((progress) => progress.gauge === gauge.name)
  if (startedAt === null) {
    return (
      <span class="progress muted" role="status">
        {read.at === null ? t.gauge.notRead : t.gauge.readAt(clock(read.at))}
      </span>
    )
  }
  return (
    <span class="progress busy" role="status">
      {t.gauge.reading}
      {progress && t.gauge.progress(progress.done, progress.total)}
      {age(performance.now() - startedAt)}
    </span>
  )
}

interface TableProps {
  block: string
  parameters: Parameter[]
  open: (request: Request) => void
}

function Table({ block, parameters, open }: TableProps): JSX.Element {
  return (
    <table class="parameters">
      <caption class="visually-hidden">{t.gauge.caption(block)}</caption>
      <thead>
        <tr>
          <th scope="col">{t.gauge.parameter}</th>
          <th scope="col">{t.common.value}</th>
          <th scope="col">{t.gauge.access}</th>
          <th scope="col">{t.gauge.location}</th>
        </tr>
      </thead>
      <tbody>
        {parameters.map((parameter) => (
          <tr key={parameter.target} data-target={parameter.target}>
            <th scope="row" lang="en">
              {parameter.name}
              <code>{parameter.target}</code>
            </th>
            <td class={parameter.read_error ? 'refusal' : 'value'}>
              <Value parameter={parameter} />
              <ChangeParameter parameter={parameter} open={open} />
            </td>
            <td>{parameter.access}</td>
            <td>{parameter.numbers}</td>
          </tr>
        ))}
      </tbody>
    </table>
  )
}

/** The value in the words of the manual, or why there is none. */
function Value({ parameter: { value, read_error } }: { parameter: Parameter }): JSX.Element {
  const text = value ?? read_error
  if (text === null) return <span>{t.gauge.writeOnly}</span>
  // The title has every digit.
  return (
    <span lang="en" title={text}>
      {readable(text)}
    </span>
  )
}
