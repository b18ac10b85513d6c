// One gauge: its readings, its commands, and all parameters of all blocks.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import type { Gauge, Outcome, Request } from '../../api/types.ts'
import { CommandDialog } from '../../components/command-dialog.tsx'
import { Choice, sameText } from '../../components/fields.tsx'
import { useSnapshot } from '../../live.ts'
import { gaugeIn, gaugePath, go, Link, useLocation } from '../../router.tsx'
import { t } from '../../texts/texts.ts'
import { GaugeAlarms } from './alarms.tsx'
import { Commands } from './commands.tsx'
import { Parameters, useParameters } from './parameters.tsx'
import { Readings } from './readings.tsx'

export function GaugePage(): JSX.Element {
  const { gauges } = useSnapshot()
  const name = gaugeIn(useLocation().path) ?? gauges[0]?.name
  const gauge = gauges.find((gauge) => gauge.name === name)
  const names = sameText(gauges.map(({ name }) => name))
  return (
    <>
      <div class="bar">
        <h1 class="visually-hidden">{t.pages['/gauge']}</h1>
        <span>
          <span aria-hidden="true">{t.common.gauge} </span>
          <Choice label={t.common.gauge} value={name ?? ''} options={names} onChange={(name) => go(gaugePath(name))} />
        </span>
        {gauge?.kind === 'gauge' && <Link to={trendPath(gauge)}>{t.gauge.showTrend}</Link>}
      </div>
      {gauge ? (
        <>
          <Readings gauge={gauge} />
          <GaugeAlarms gauge={gauge} key={gauge.name} />
          {gauge.kind === 'slave' && <Slave gauge={gauge} />}
          {gauge.kind === 'gauge' && gauge.listen_only && <Listening gauge={gauge} />}
          {gauge.kind === 'gauge' && !gauge.listen_only && <Operation gauge={gauge} key={gauge.name} />}
        </>
      ) : (
        <p class="error">{name ? t.gauge.unknown(name) : t.gauge.none}</p>
      )}
    </>
  )
}

const trendPath = ({ readings }: Gauge): string =>
  `/trends?${new URLSearchParams(readings.map(({ series }) => ['s', series]))}`

/** A slave by its GSD file: the station reads its points and offers no commands. */
function Slave({ gauge }: { gauge: Gauge }): JSX.Element {
  return (
    <section class="panel" aria-label={t.gauge.slave}>
      <h2>{t.gauge.slave}</h2>
      <p>{gauge.listen_only ? t.gauge.slaveRead : t.gauge.slaveOwned}</p>
    </section>
  )
}

/** A gauge of another master: the station sends nothing, and says what it does not know. */
function Listening({ gauge }: { gauge: Gauge }): JSX.Element {
  return (
    <section class="panel" aria-label={t.gauge.listenOnly}>
      <h2>{t.gauge.listenOnly}</h2>
      <p>{t.gauge.listening}</p>
      {gauge.assumptions.map((text) => (
        <p class="error" key={text}>
          {text}.
        </p>
      ))}
    </section>
  )
}

/** Commands and parameters, and the dialog of the one that is chosen. */
function Operation({ gauge }: { gauge: Gauge }): JSX.Element {
  const [request, setRequest] = useState<Request | null>(null)
  const [outcome, setOutcome] = useState<Outcome | null>(null)
  const reading = useParameters(gauge, outcome)
  const close = (outcome: Outcome | null): void => {
    setRequest(null)
    setOutcome(outcome)
  }
  return (
    <>
      <Commands gauge={gauge} open={setRequest} read={reading.read} />
      <Parameters gauge={gauge} open={setRequest} reading={reading} />
      {request && <CommandDialog gauge={gauge.name} request={request} close={close} />}
    </>
  )
}
