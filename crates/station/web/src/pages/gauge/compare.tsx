// The settings of the gauge beside those of another one of the same model, and the values of the other one taken over.

import type { JSX } from 'preact'
import { useRef, useState } from 'preact/hooks'
import { readBlocks } from '../../api/calls.ts'
import type { Block, Gauge, Request } from '../../api/types.ts'
import { Choice, sameText } from '../../components/fields.tsx'
import { errorText } from '../../components/hooks.ts'
import { QueryState } from '../../components/query-state.tsx'
import { compared, type Difference } from '../../lib/compare-settings.ts'
import { useSnapshot } from '../../live.ts'
import { hasRole, useSession } from '../../session.ts'
import { t } from '../../texts/texts.ts'
import { ChangeButton } from './change-button.tsx'
import { obstacle } from './permission.ts'

interface Props {
  gauge: Gauge
  blocks: Block[]
  open: (request: Request) => void
}

interface Other {
  name: string
  blocks: Block[] | null
  error: string | null
}

/** Nothing if the station has no other gauge of the model. */
export function Compare({ gauge, blocks, open }: Props): JSX.Element | null {
  const { gauges } = useSnapshot()
  const [other, setOther] = useState<Other | null>(null)
  const wanted = useRef('')
  const names = gauges
    .filter(({ name, device, listen_only }) => device === gauge.device && name !== gauge.name && !listen_only)
    .map(({ name }) => name)
  if (names.length === 0) return null
  const choose = async (name: string): Promise<void> => {
    wanted.current = name
    setOther(name === '' ? null : { name, blocks: null, error: null })
    if (name === '') return
    const read = await readBlocks(name).then(
      (blocks): Other => ({ name, blocks, error: null }),
      (error: unknown): Other => ({ name, blocks: null, error: errorText(error) }),
    )
    // Another gauge may have been chosen meanwhile.
    if (wanted.current === name) setOther(read)
  }
  return (
    <>
      <div class="bar">
        <Choice
          label={t.compare.with}
          value={other?.name ?? ''}
          options={[['', `${t.compare.with} …`], ...sameText(names)]}
          onChange={(name) => void choose(name)}
        />
      </div>
      {other && (
        <QueryState
          of={[{ value: other.blocks, error: other.error, again: () => void choose(other.name) }]}
          loading={t.compare.reading(other.name)}
        />
      )}
      {other?.blocks && <Result gauge={gauge} own={blocks} name={other.name} other={other.blocks} open={open} />}
    </>
  )
}

interface ResultProps {
  gauge: Gauge
  own: Block[]
  name: string
  other: Block[]
  open: (request: Request) => void
}

function Result({ gauge, own, name, other, open }: ResultProps): JSX.Element {
  const { compared: total, differences } = compared(own, other)
  return (
    <section class="comparison" aria-label={t.compare.title(name)}>
      <p role="status">{t.compare.counted(differences.length, total)}</p>
      {differences.length > 0 && (
        <table class="parameters">
          <caption class="visually-hidden">{t.compare.title(name)}</caption>
          <thead>
            <tr>
              <th scope="col">{t.gauge.parameter}</th>
              <th scope="col">{gauge.name}</th>
              <th scope="col">{name}</th>
              <th scope="col">{t.compare.action}</th>
            </tr>
          </thead>
          <tbody>
            {differences.map((difference) => (
              <Row difference={difference} names={[gauge.name, name]} open={open} key={difference.parameter.target} />
            ))}
          </tbody>
        </table>
      )}
    </section>
  )
}

interface RowProps {
  difference: Difference
  /** The names of the gauge and of the other one, which a phone shows beside the values. */
  names: [string, string]
  open: (request: Request) => void
}

/** Each value is taken over as a change of its own, with its conditions, its risk and its row in the audit trail. */
function Row({ difference, names, open }: RowProps): JSX.Element {
  const { parameter, other } = difference
  const { target, name, value, write } = parameter
  return (
    <tr data-difference={target}>
      <th scope="row" lang="en">
        {name}
        <code>{target}</code>
      </th>
      <td class="value" lang="en" data-of={names[0]}>
        {value}
      </td>
      <td class="value" lang="en" data-of={names[1]}>
        {other}
      </td>
      <td>{write && <TakeOver write={write} name={name} take={() => open({ target, value: other })} />}</td>
    </tr>
  )
}

interface TakeOverProps {
  write: NonNullable<Difference['parameter']['write']>
  name: string
  take: () => void
}

function TakeOver({ write, name, take }: TakeOverProps): JSX.Element {
  const session = useSession()
  const reason = obstacle(session, useSnapshot().control_authority, write.role, write.blocked_reason)
  if (write.blocked_reason !== null || !hasRole(session, write.role)) return <span class="muted">{reason}</span>
  return (
    <ChangeButton label={t.compare.takeOverOf(name)} reason={reason} press={take}>
      {t.compare.takeOver}
    </ChangeButton>
  )
}
