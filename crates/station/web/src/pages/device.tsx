// One gauge: what it shows, and every parameter of every block, read from it when asked.

import type { JSX } from 'preact'
import { useEffect, useState } from 'preact/hooks'
import type { Outcome, Wish } from '../acting.ts'
import { blocks, type Block, type Gauge, type Parameter } from '../api.ts'
import { useLive, type Live } from '../live.ts'
import { Commands, obstacle } from '../parts/commands.tsx'
import { OrderPanel, RiskMark } from '../parts/order.tsx'
import { Limit, Shown } from '../parts/pressure.tsx'
import { Spark } from '../parts/spark.tsx'
import { StandingMark } from '../parts/standing.tsx'
import { sentence } from '../parts/use.ts'
import { age, clock } from '../pure/format.ts'
import { matching } from '../pure/search.ts'
import { isStale, worth } from '../pure/stale.ts'
import type { Unit } from '../pure/units.ts'
import { PRINCIPLES } from '../pure/words.ts'
import { gaugePath, go, Link, nameIn, usePlace } from '../router.tsx'
import { isIn, may, onChange, useSession } from '../session.ts'
import { useUnit } from '../settings.ts'
import { Age, Complaints, Corrected } from './overview.tsx'

export function Device(): JSX.Element {
  const live = useLive()
  const unit = useUnit()
  const { gauges } = live.moment!
  const name = nameIn(usePlace().path) ?? gauges[0]?.name
  const gauge = gauges.find((gauge) => gauge.name === name)
  return (
    <>
      <div class="bar">
        <h1 class="unseen">Gauge</h1>
        <label>
          Gauge{' '}
          <select value={name} onChange={(event) => go(gaugePath(event.currentTarget.value))}>
            {gauges.map(({ name }) => (
              <option value={name} key={name}>
                {name}
              </option>
            ))}
          </select>
        </label>
        {gauge && (
          <Link to={`/trends?${new URLSearchParams(gauge.readings.map(({ series }) => ['s', series]))}`}>
            Its trend
          </Link>
        )}
      </div>
      {gauge ? (
        <>
          <Now gauge={gauge} live={live} unit={unit} />
          <Acting gauge={gauge} key={gauge.name} />
        </>
      ) : (
        <p class="alarm">
          {name ? `There is no gauge called ${name}. Choose another one above.` : 'There is no gauge in the station.'}
        </p>
      )}
    </>
  )
}

function Now({ gauge, live, unit }: { gauge: Gauge; live: Live; unit: Unit }): JSX.Element {
  const stale = isStale(gauge, live.since)
  return (
    <section class={`panel now ${stale ? 'stale' : ''}`} aria-label="Now">
      <div class="now-head">
        <h2>{gauge.name}</h2>
        <StandingMark standing={gauge.standing} old={stale && gauge.standing === 'exchanging'} />
        <span class="muted">
          {gauge.device} · {gauge.segment} · address {gauge.address}
        </span>
        <Age gauge={gauge} live={live} />
      </div>
      <div class="now-readings">
        {gauge.readings.map((reading) => {
          const quality = worth(gauge, reading, live.since)
          return (
            <div class="now-reading" key={reading.series}>
              <p class="big">
                <Shown pa={reading.pa} quality={quality} unit={unit} />
              </p>
              <p class="beside">
                <span class="sensor">{reading.principle && PRINCIPLES[reading.principle]}</span>
                <Limit pa={reading.pa} quality={quality} unit={unit} />
                {quality === 'valid' && <Corrected gauge={gauge} reading={reading} unit={unit} />}
              </p>
              <Spark series={reading.series} dim={stale} />
            </div>
          )
        })}
        {gauge.readings.length === 0 && <p class="big none">no data</p>}
      </div>
      <Complaints gauge={gauge} />
    </section>
  )
}

/** Commands and parameters, and the panel over them when somebody acts. */
function Acting({ gauge }: { gauge: Gauge }): JSX.Element {
  const [wish, setWish] = useState<Wish | null>(null)
  const [done, setDone] = useState<Outcome | null>(null)
  const close = (outcome: Outcome | null): void => {
    setWish(null)
    setDone(outcome)
  }
  return (
    <>
      <Commands gauge={gauge} begin={setWish} />
      <Blocks gauge={gauge} begin={setWish} done={done} />
      {wish && <OrderPanel gauge={gauge.name} wish={wish} close={close} />}
    </>
  )
}

interface Read {
  blocks: Block[] | null
  at: number | null
  error: string | null
}

/** What was read is kept while the dashboard is open: reading takes time of the bus. */
const kept = new Map<string, Read>()
onChange(() => isIn() || kept.clear())

function Blocks({
  gauge,
  begin,
  done,
}: {
  gauge: Gauge
  begin: (wish: Wish) => void
  done: Outcome | null
}): JSX.Element {
  const [read, setRead] = useState<Read>(kept.get(gauge.name) ?? { blocks: null, at: null, error: null })
  const [begun, setBegun] = useState<number | null>(null)
  const [wanted, setWanted] = useState('')
  const again = async (): Promise<void> => {
    setBegun(performance.now())
    const next: Read = await blocks(gauge.name).then(
      (blocks) => ({ blocks, at: Date.now(), error: null }),
      (error: unknown) => ({ ...read, error: sentence(error) }),
    )
    kept.set(gauge.name, next)
    setRead(next)
    setBegun(null)
  }
  useEffect(() => {
    if (!kept.has(gauge.name) && (gauge.standing === 'exchanging' || gauge.standing === 'faulty')) void again()
  }, [])
  // What was written was read back: it need not be read again.
  useEffect(() => {
    if (done === null || done.after === null || read.blocks === null) return
    const next = {
      ...read,
      blocks: read.blocks.map((block) => ({ ...block, parameters: block.parameters.map((it) => written(it, done)) })),
    }
    kept.set(gauge.name, next)
    setRead(next)
  }, [done])
  const found = matching(read.blocks ?? [], wanted)
  return (
    <section class="panel blocks" aria-label="Parameters" aria-busy={begun !== null}>
      <div class="bar">
        <h2>Parameters</h2>
        <input
          type="search"
          placeholder="Search"
          aria-label="Search parameters"
          value={wanted}
          onInput={(event) => setWanted(event.currentTarget.value)}
        />
        <button type="button" class="main" onClick={again} disabled={begun !== null}>
          Read again
        </button>
        <Progress gauge={gauge} begun={begun} read={read} />
      </div>
      {read.error && <p class="alarm">{read.error}</p>}
      {found.map(({ name, parameters }) => (
        <details open key={name}>
          <summary>
            {name} <span class="muted">{parameters.length}</span>
          </summary>
          <Table parameters={parameters} begin={begin} />
        </details>
      ))}
      {read.blocks && found.length === 0 && <p class="muted">Nothing is called {wanted}.</p>}
    </section>
  )
}

function Progress({ gauge, begun, read }: { gauge: Gauge; begun: number | null; read: Read }): JSX.Element {
  const so = useLive().moment?.reading.find((one) => one.gauge === gauge.name)
  const far = so ? `${so.done} of ${so.of}, ` : ''
  const words =
    begun !== null
      ? `reading … ${far}${age(performance.now() - begun)}`
      : read.at !== null
        ? `read at ${clock(read.at)}`
        : 'not read yet'
  return (
    <span class={begun === null ? 'progress muted' : 'progress busy'} role="status">
      {words}
    </span>
  )
}

function written(parameter: Parameter, { target, after }: Outcome): Parameter {
  return parameter.target === target ? { ...parameter, value: after, refusal: null } : parameter
}

function Table({ parameters, begin }: { parameters: Parameter[]; begin: (wish: Wish) => void }): JSX.Element {
  return (
    <table class="parameters">
      <thead>
        <tr>
          <th>Parameter</th>
          <th>Value</th>
          <th>Access</th>
          <th>Where</th>
        </tr>
      </thead>
      <tbody>
        {parameters.map((parameter) => (
          <tr key={parameter.target} data-target={parameter.target}>
            <th scope="row">
              {parameter.name}
              <code>{parameter.target}</code>
            </th>
            <td class={parameter.refusal ? 'refusal' : 'value'}>
              {parameter.value ?? parameter.refusal ?? 'only written'}
              <Change parameter={parameter} begin={begin} />
            </td>
            <td>{parameter.access}</td>
            <td>{parameter.numbers}</td>
          </tr>
        ))}
      </tbody>
    </table>
  )
}

/** The way to another value, for who may. */
function Change({ parameter, begin }: { parameter: Parameter; begin: (wish: Wish) => void }): JSX.Element | null {
  const session = useSession()
  const { mastership } = useLive().moment!
  const [open, setOpen] = useState(false)
  const { target, name, value, write } = parameter
  // What one's role never allows needs no button at every row: the line above says so.
  if (write === null || !may(session, write.role)) return null
  if (write.barred !== null) {
    return (
      <details class="barred">
        <summary>not from here</summary>
        {write.barred}
      </details>
    )
  }
  const reason = obstacle(session, mastership, write.role, null)
  if (!open || reason !== null) {
    return (
      <button
        type="button"
        class="change"
        disabled={reason !== null}
        title={reason ?? undefined}
        aria-label={`Change ${name}`}
        onClick={() => setOpen(true)}
      >
        Change
      </button>
    )
  }
  const arm = (event: JSX.TargetedSubmitEvent<HTMLFormElement>): void => {
    event.preventDefault()
    begin({ target, value: String(new FormData(event.currentTarget).get('value') ?? '') })
    setOpen(false)
  }
  return (
    <form class="change" onSubmit={arm}>
      {write.choices.length > 0 ? (
        <select name="value" aria-label={`New value of ${name}`} autofocus>
          {write.choices.map((choice) => (
            <option value={choice} selected={choice === value} key={choice}>
              {choice}
            </option>
          ))}
        </select>
      ) : (
        <input
          name="value"
          aria-label={`New value of ${name}`}
          defaultValue={value ?? ''}
          autocomplete="off"
          required
          autofocus
        />
      )}
      <button class="main">Arm</button>
      <button type="button" onClick={() => setOpen(false)}>
        Cancel
      </button>
      <span class="muted takes">
        <RiskMark risk={write.risk} /> {write.choices.length === 0 && write.takes}
      </span>
    </form>
  )
}
