// The numbers of a plant with their intervals, what is not determined in words, the pressure to come, and what would help.

import type { ComponentChildren, JSX } from 'preact'
import type { Bounds, Certainty, Plant, Remedy } from '../../api/types.ts'
import { Pressure } from '../../components/pressure.tsx'
import { Sprays } from '../../components/sprays.tsx'
import { age, number } from '../../lib/format.ts'
import { boundsText, ratioText, timesText, worth } from '../../lib/plant.ts'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'

interface Props {
  plant: Plant
  /** The target as typed. */
  target: string
}

export function Result({ plant, target }: Props): JSX.Element {
  const { title, sentence } = worth(plant)
  return (
    <section class="panel result" aria-label={t.identify.result}>
      <h2>{title}</h2>
      <p>{sentence}</p>
      <Numbers plant={plant} />
      <p class="muted">
        {t.identify.samples(plant.samples)}{' '}
        {plant.rise
          ? t.identify.valve(age(plant.rise.closed_s * 1000), age(plant.rise.opened_s * 1000))
          : t.identify.noRise}{' '}
        {t.identify.intervals(
          plant.accuracy === null
            ? t.common.withoutAccuracy
            : t.common.withAccuracy(number((plant.accuracy ?? 0) * 100)),
        )}
      </p>
      <Sprays sprays={plant.sprays} />
      <Outlook plant={plant} target={target} />
      <h3>{t.identify.helps}</h3>
      <p class="muted">{t.identify.helpsHow}</p>
      <ol class="remedies">
        {plant.remedies.map(({ remedy, divided_by }) => (
          <li key={remedy}>
            {remedyText(remedy)}: <strong>{ratioText(divided_by).value}</strong> ({ratioText(divided_by).interval})
          </li>
        ))}
      </ol>
    </section>
  )
}

const remedyText = (remedy: Remedy): string => t.identify.remedies[remedy]

interface Row {
  name: ComponentChildren
  value: Bounds
  /** The unit, and its size in that of the API; `null` for a number without a unit. */
  unit: { name: string; size: number } | null
  note: string | null
}

/** Why a number is not determined; `bound` if the samples have its upper bound. */
function noteOf(certainty: Certainty, undetermined: string, bound = undetermined): string | null {
  if (certainty === 'determined') return null
  return certainty === 'upper-bound' ? bound : undetermined
}

function Numbers({ plant }: { plant: Plant }): JSX.Element {
  const unit = useUnit()
  const { notes } = t.identify
  const flow = (name: string, { flow }: Plant['leak'], note: string | null): Row => ({
    name,
    value: flow.mbar_l_per_s,
    unit: { name: 'mbar L/s', size: 1 },
    note,
  })
  const rows: Row[] = [
    {
      name: t.identify.volumeName,
      value: plant.volume_m3.value,
      unit: { name: 'L', size: 1e-3 },
      note: plant.is_volume_given ? t.identify.asGiven : noteOf(plant.volume_m3.certainty, notes.volume),
    },
    ...plant.speeds.map(({ pa, m3_per_s: { value, certainty } }) => ({
      name: t.identify.speedAt(<Pressure pa={pa} unit={unit} />),
      value,
      unit: { name: 'L/s', size: 1e-3 },
      note: noteOf(certainty, notes.speed),
    })),
    flow(t.identify.leak, plant.leak, noteOf(plant.leak.certainty, notes.leak, notes.leakBound)),
    flow(t.identify.outgassing, plant.outgassing_1h, noteOf(plant.outgassing_1h.certainty, notes.outgassing)),
    {
      name: t.identify.exponent,
      value: plant.exponent.value,
      unit: null,
      note: noteOf(plant.exponent.certainty, notes.exponent),
    },
  ]
  const { value, certainty } = plant.ultimate_pa
  const note = noteOf(certainty, notes.ultimate, notes.ultimateBound)
  return (
    <table>
      <caption class="visually-hidden">{t.identify.numbers}</caption>
      <thead>
        <tr>
          <th scope="col">{t.identify.quantity}</th>
          <th scope="col">{t.common.value}</th>
          <th scope="col">{t.identify.interval}</th>
        </tr>
      </thead>
      <tbody>
        {rows.map((row, place) => (
          <NumberRow key={place} row={row} />
        ))}
        <tr>
          <th scope="row">
            {t.identify.ultimate}
            {note && <small>{note}</small>}
          </th>
          <td>
            <Estimate bounds={value} />
          </td>
          <td>
            <PressureInterval bounds={value} />
          </td>
        </tr>
      </tbody>
    </table>
  )
}

function NumberRow({ row: { name, value, unit, note } }: { row: Row }): JSX.Element {
  const texts = unit ? boundsText(value, unit.size) : ratioText(value)
  return (
    <tr>
      <th scope="row">
        {name}
        {note && <small>{note}</small>}
      </th>
      <td>
        {texts.value} {unit?.name}
      </td>
      <td>{texts.interval}</td>
    </tr>
  )
}

/** The estimate; its upper bound if it cannot be told from zero. */
function Estimate({ bounds: { mean, high } }: { bounds: Bounds }): JSX.Element {
  const unit = useUnit()
  if (mean > 0 || high === null || high === undefined) return <Pressure pa={mean} unit={unit} />
  return (
    <>
      {'< '}
      <Pressure pa={high} unit={unit} />
    </>
  )
}

function PressureInterval({ bounds: { low, high } }: { bounds: Bounds }): JSX.Element {
  const unit = useUnit()
  return (
    <>
      {t.common.range(
        <Pressure pa={low} unit={unit} />,
        high === null || high === undefined ? t.identify.noLimit : <Pressure pa={high} unit={unit} />,
      )}
    </>
  )
}

function Outlook({ plant, target }: Props): JSX.Element {
  const unit = useUnit()
  const { by_leak, by_outgassing, by_pump } = plant.at_end_pa
  const facts: [string, Bounds][] = [
    [t.identify.byLeak, by_leak],
    [t.identify.byOutgassing, by_outgassing],
    [t.identify.byPump, by_pump],
    [t.identify.anotherDay, plant.after_another_day_pa],
  ]
  return (
    <dl class="facts">
      {facts.map(([name, bounds]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>
            <Estimate bounds={bounds} /> (<PressureInterval bounds={bounds} />)
          </dd>
        </div>
      ))}
      {target !== '' && (
        <div>
          <dt>{t.identify.reached(target, unit)}</dt>
          <dd>{plant.target_s ? timesText(plant.target_s) : t.identify.notWithinAYear}</dd>
        </div>
      )}
    </dl>
  )
}
